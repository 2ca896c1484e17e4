//! Audio files of other programs: encodings, sizes of 64 bits, tags and paddings.

use std::io::Cursor;

use wav_files::{WavReader, WavWarning};

/// Returns the chunks of a file, framed by a RIFF header that states their length.
fn riff(kind: [u8; 4], size: Option<u32>, chunks: &[&[u8]]) -> Vec<u8> {
    let content = chunks.concat();
    let size = size.unwrap_or(content.len() as u32 + 4);
    [&kind[..], &size.to_le_bytes(), b"WAVE", &content].concat()
}

fn chunk(id: &[u8; 4], content: &[u8]) -> Vec<u8> {
    [&id[..], &(content.len() as u32).to_le_bytes(), content].concat()
}

/// Returns a format chunk of one channel at 96 kHz.
fn format_chunk(tag: u16, bits: u16, bytes: u16) -> Vec<u8> {
    let rate = 96_000u32.to_le_bytes();
    let rate_bytes = (96_000 * u32::from(bytes)).to_le_bytes();
    let words = [tag, 1].map(u16::to_le_bytes).concat();
    let sizes = [bytes, bits].map(u16::to_le_bytes).concat();
    chunk(b"fmt ", &[&words[..], &rate, &rate_bytes, &sizes].concat())
}

fn wav_samples(file: Vec<u8>) -> (Vec<f32>, Vec<WavWarning>) {
    let (mut reader, warnings) = WavReader::new(Cursor::new(file)).unwrap();
    let mut block = Vec::new();
    reader.read_block(1000, &mut block).unwrap();
    (block, warnings)
}

#[test]
fn files_of_other_writers_are_read() {
    let values = [0.5, -0.25, 0.125];
    let floats: Vec<u8> = values.iter().flat_map(|v: &f32| v.to_le_bytes()).collect();
    let doubles: Vec<u8> = values
        .iter()
        .flat_map(|v| f64::from(*v).to_le_bytes())
        .collect();
    let low_24_bits: Vec<u8> = values
        .iter()
        .flat_map(|v| ((v * 8_388_608.0) as i32 + 1).to_le_bytes())
        .collect();
    let (format, data) = (format_chunk(3, 32, 4), chunk(b"data", &floats));
    let expected = (values.to_vec(), Vec::new());

    let file = riff(
        *b"RIFF",
        None,
        &[&format_chunk(3, 64, 8), &chunk(b"data", &doubles)],
    );
    assert_eq!(wav_samples(file), expected);

    let file = riff(
        *b"RIFF",
        None,
        &[&format_chunk(1, 24, 4), &chunk(b"data", &low_24_bits)],
    );
    let (samples, _) = wav_samples(file);
    for (sample, value) in samples.iter().zip(values) {
        assert!((sample - value).abs() < 2e-7, "{sample}");
    }

    // A tag that its program did not count in the header, and an odd chunk without a pad byte.
    let mut file = riff(*b"RIFF", None, &[&chunk(b"bext", b"odd"), &format, &data]);
    file.extend(chunk(b"LIST", b"INFOISFT"));
    file.extend([&b"TAG"[..], &[0; 125]].concat());
    assert_eq!(wav_samples(file), expected);

    // Sizes of 64 bits.
    let sizes = [100u64, 12, 3].map(u64::to_le_bytes).concat();
    let mut long_data = data.clone();
    long_data[4..8].fill(0xff);
    let sizes = chunk(b"ds64", &[&sizes[..], &[0; 4]].concat());
    let tag = chunk(b"LIST", b"INFO");
    for kind in [b"RF64", b"BW64"] {
        let chunks: [&[u8]; 4] = [&sizes, &format, &long_data, &tag];
        let file = riff(*kind, Some(u32::MAX), &chunks);
        assert_eq!(wav_samples(file), expected);
    }
    let piped = riff(*b"RIFF", Some(u32::MAX), &[&format, &long_data]);
    let no_length = WavWarning::NoLength { present_bytes: 12 };
    assert_eq!(wav_samples(piped), (values.to_vec(), vec![no_length]));
}

#[test]
fn an_extensible_header_states_the_valid_bits() {
    let guid = b"\x01\0\0\0\0\0\x10\0\x80\0\0\xaa\0\x38\x9b\x71";
    let mut format = format_chunk(0xfffe, 32, 4);
    format[4..8].copy_from_slice(&40u32.to_le_bytes());
    format.extend([22, 0, 24, 0, 4, 0, 0, 0]);
    format.extend(guid);
    let high: Vec<u8> = [1 << 30, -(1 << 29)]
        .iter()
        .flat_map(|value: &i32| value.to_le_bytes())
        .collect();
    let file = riff(*b"RIFF", None, &[&format, &chunk(b"data", &high)]);
    assert_eq!(wav_samples(file), (vec![0.5, -0.25], Vec::new()));
}
