//! Files and channels that are refused, by name.

use std::io::Cursor;

use tdms_files::TdmsFile;

use crate::files;
use crate::writer::{
    DAQMX_RAW, F64, I16, Index, METADATA, NEW_LIST, Property, RAW, Scaler, Segment, Type,
};

fn refusal(bytes: Vec<u8>) -> String {
    TdmsFile::open(Cursor::new(bytes)).unwrap_err().to_string()
}

fn segment(objects: Vec<(&'static str, Index, Vec<Property>)>, samples: &[u8]) -> Vec<u8> {
    Segment {
        mask: METADATA | NEW_LIST | RAW,
        is_big_endian: false,
        objects,
        samples: samples.to_vec(),
    }
    .bytes()
}

#[test]
fn other_files_and_indices_are_refused_by_name() {
    let (_, whole) = files::all().swap_remove(0);
    let mut index = whole.clone();
    index[3] = b'h';
    assert!(refusal(index).contains("name the .tdms file of the same name"));
    assert!(refusal(b"RIFF1234WAVE".to_vec()).contains("not a TDMS file"));
    assert!(refusal(vec![]).contains("not a TDMS file"));
    assert!(refusal(whole[..20].to_vec()).contains("ends before byte 28"));
}

#[test]
fn damaged_segments_are_refused_with_their_place() {
    let (_, whole) = files::all().swap_remove(0);
    let damaged = [whole.clone(), b"something else, and not a segment".to_vec()].concat();
    let place = format!("segment 2, byte {}", whole.len());
    assert!(refusal(damaged).starts_with(&place));
    let before = vec![("/'g'/'a'", Index::AsBefore, vec![])];
    assert!(refusal(segment(before, &[])).contains("/'g'/'a' has samples as before"));
    let unlisted = segment(vec![("/'g'/'a'", Index::None, vec![])], &[1, 2, 3]);
    assert!(refusal(unlisted).contains("3 bytes of samples that no channel lists"));
    let different = Segment {
        mask: METADATA | NEW_LIST | RAW | crate::writer::INTERLEAVED,
        is_big_endian: false,
        objects: vec![
            ("/'g'/'a'", Index::Plain(I16, 3), vec![]),
            ("/'g'/'b'", Index::Plain(I16, 2), vec![]),
        ],
        samples: vec![0; 10],
    };
    assert!(refusal(different.bytes()).contains("different lengths (/'g'/'b')"));
}

#[test]
fn unknown_types_are_refused_by_name() {
    let unknown = segment(
        vec![("/'g'/'a'", Index::Plain(Type(0x1b), 2), vec![])],
        &[0; 32],
    );
    let refusal = refusal(unknown);
    assert!(
        refusal.contains("/'g'/'a'") && refusal.contains("0x1b"),
        "{refusal}"
    );
}

/// Returns the refusal of the first channel's samples, and requires that the second can be read.
fn channel_refusal(bytes: Vec<u8>) -> String {
    let mut file = TdmsFile::open(Cursor::new(bytes)).unwrap();
    let mut samples = Vec::new();
    let refusal = file.read(0, 0..1, &mut samples).unwrap_err().to_string();
    file.read(1, 0..1, &mut samples).unwrap();
    assert_eq!(samples.len(), 1);
    assert!(file.channels()[0].unread().is_some());
    refusal
}

fn scaled(scale: Vec<Property>) -> Vec<u8> {
    let objects = vec![
        ("/'g'/'a'", Index::Plain(F64, 1), scale),
        ("/'g'/'b'", Index::Plain(F64, 1), vec![]),
    ];
    segment(objects, &[0; 16])
}

#[test]
fn a_scale_that_is_not_read_leaves_the_other_channels() {
    for kind in ["RTD", "Thermocouple", "Thermistor", "Strain"] {
        let scale = vec![
            Property::U32("NI_Number_Of_Scales", 1),
            Property::Text("NI_Scale[0]_Scale_Type", kind),
        ];
        let refusal = channel_refusal(scaled(scale));
        assert!(
            refusal.contains("g/a") && refusal.contains(kind),
            "{refusal}"
        );
        assert!(
            refusal.contains("let LabVIEW write the channel scaled"),
            "{refusal}"
        );
    }
}

#[test]
fn an_unknown_daqmx_type_leaves_the_other_channels() {
    let index = |kind, offset| Index::Daqmx {
        mark: 0x1269,
        values: 2,
        scalers: vec![Scaler(kind, 0, offset, 0)],
        widths: vec![6],
    };
    let task = Segment {
        mask: METADATA | NEW_LIST | RAW | DAQMX_RAW,
        is_big_endian: false,
        objects: vec![
            ("/'t'/'ai0'", index(77, 0), vec![]),
            ("/'t'/'ai1'", index(3, 4), vec![]),
        ],
        samples: vec![1; 12],
    };
    let refusal = channel_refusal(task.bytes());
    assert!(
        refusal.contains("t/ai0") && refusal.contains("DAQmx type (77)"),
        "{refusal}"
    );
}

#[test]
fn chains_of_scales_that_do_not_end_are_refused() {
    let circle = vec![
        Property::U32("NI_Number_Of_Scales", 2),
        Property::Text("NI_Scale[0]_Scale_Type", "AdvancedAPI"),
        Property::U32("NI_Scale[0]_AdvancedAPI_Input_Source", 1),
        Property::Text("NI_Scale[1]_Scale_Type", "AdvancedAPI"),
        Property::U32("NI_Scale[1]_AdvancedAPI_Input_Source", 0),
    ];
    assert!(channel_refusal(scaled(circle)).contains("leads to no stored number"));
    let missing = vec![
        Property::Text("NI_Scale[0]_Scale_Type", "AdvancedAPI"),
        Property::U32("NI_Scale[0]_AdvancedAPI_Input_Source", 9),
    ];
    assert!(channel_refusal(scaled(missing)).contains("leads to no stored number"));
    let flat = vec![
        Property::Text("NI_Scale[0]_Scale_Type", "Linear"),
        Property::F64("NI_Scale[0]_Linear_Y_Intercept", 1.0),
    ];
    assert!(channel_refusal(scaled(flat)).contains("without a slope"));
}

#[test]
fn complex_samples_are_not_read_as_real_ones() {
    let (_, bytes) = files::all()
        .into_iter()
        .find(|(name, _)| *name == "complex")
        .unwrap();
    let mut file = TdmsFile::open(Cursor::new(bytes)).unwrap();
    let error = file.read(0, 0..1, &mut Vec::new()).unwrap_err();
    assert_eq!(error.to_string(), "g/z has complex samples");
    assert!(file.read(9, 0..1, &mut Vec::new()).is_err());
}
