//! Any bytes as `signals.wav`: an error or samples, as many as promised.
#![no_main]

use std::io::Cursor;

use friction_bench::recording::wav::WavReader;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let Ok((mut reader, _)) = WavReader::new(Cursor::new(bytes)) else {
        return;
    };
    let promised = reader.frames();
    let (mut read, mut block) = (0, Vec::new());
    while let Ok(frames) = reader.read_block(1024, &mut block) {
        if frames == 0 {
            break;
        }
        read += frames as u64;
    }
    assert_eq!(read, promised);
});
