//! Files of each kind that the note allows, by name.

use crate::writer::{
    Bytes, COMPLEX64, COMPLEX128, DAQMX_RAW, F32, F64, I16, I32, INTERLEAVED, Index, METADATA,
    NEW_LIST, Property, RAW, Scaler, Segment, TIME, U8,
};

const ALL: u32 = METADATA | NEW_LIST | RAW;

fn segment(
    mask: u32,
    objects: Vec<(&'static str, Index, Vec<Property>)>,
    samples: Vec<u8>,
) -> Segment {
    Segment {
        mask,
        is_big_endian: false,
        objects,
        samples,
    }
}

fn little() -> Bytes {
    Bytes::new(false)
}

fn ramp(count: i16) -> impl Iterator<Item = i16> {
    (0..count).map(|n| n * 7 - 100)
}

/// Returns files and their names.
pub fn all() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("contiguous", contiguous(false)),
        ("big_endian", contiguous(true)),
        ("interleaved", interleaved(false)),
        ("interleaved_big_endian", interleaved(true)),
        ("many_chunks", many_chunks()),
        ("changed_lists", changed_lists()),
        ("without_metadata", without_metadata()),
        ("cut", cut()),
        ("cut_interleaved", cut_interleaved()),
        ("part_of_a_chunk", part_of_a_chunk()),
        (
            "cut_lead_in",
            [contiguous(false), b"TDSm\x0e\0\0\0".to_vec()].concat(),
        ),
        ("complex", complex()),
        ("times", times()),
        ("daqmx", daqmx(false)),
        ("daqmx_big_endian", daqmx(true)),
        ("daqmx_lines", daqmx_lines()),
        ("daqmx_two_buffers", daqmx_two_buffers()),
        ("daqmx_cut", daqmx_cut()),
        ("scales", scales()),
        ("scales_of_group", scales_of_group()),
        ("texts_between", texts_between()),
    ]
}

fn waveform() -> Vec<Property> {
    vec![
        Property::F64("wf_increment", 1.0 / 48_000.0),
        Property::F64("wf_start_offset", 0.25),
        Property::Time("wf_start_time", 3_850_000_000, 1 << 63),
        Property::Text("unit_string", "V"),
    ]
}

fn contiguous(is_big_endian: bool) -> Vec<u8> {
    let samples = Bytes::new(is_big_endian)
        .i16s(ramp(5))
        .f64s([1.5, -2.25, 1e300])
        .f32s([0.1, 3.0]);
    Segment {
        mask: ALL,
        is_big_endian,
        objects: vec![
            ("/", Index::None, vec![Property::Text("title", "é")]),
            ("/'g'", Index::None, vec![]),
            ("/'g'/'it''s'", Index::Plain(I16, 5), waveform()),
            ("/'g'/'b'", Index::Plain(F64, 3), vec![]),
            ("/'h'/'c'", Index::Plain(F32, 2), vec![]),
        ],
        samples: samples.bytes,
    }
    .bytes()
}

fn interleaved(is_big_endian: bool) -> Vec<u8> {
    let mut samples = Bytes::new(is_big_endian);
    for n in 0..6 {
        samples = samples.i16s([n]).f64s([f64::from(n) / 3.0]).i16s([-n]);
    }
    Segment {
        mask: ALL | INTERLEAVED,
        is_big_endian,
        objects: vec![
            ("/'g'/'a'", Index::Plain(I16, 3), vec![]),
            ("/'g'/'b'", Index::Plain(F64, 3), vec![]),
            ("/'g'/'c'", Index::Plain(I16, 3), vec![]),
        ],
        samples: samples.bytes,
    }
    .bytes()
}

/// Two channels of two values each, in 50 chunks of one segment.
fn many_chunks() -> Vec<u8> {
    let objects = vec![
        ("/'g'/'a'", Index::Plain(I16, 2), vec![]),
        ("/'g'/'b'", Index::Plain(F64, 2), vec![]),
    ];
    let samples = (0..50).fold(little(), |bytes, n| {
        bytes.i16s([n, n + 1]).f64s([f64::from(n), 0.5])
    });
    segment(ALL, objects, samples.bytes).bytes()
}

fn changed_lists() -> Vec<u8> {
    let changes = METADATA | RAW;
    [
        segment(
            ALL,
            vec![
                ("/'g'/'a'", Index::Plain(I16, 2), vec![]),
                ("/'g'/'b'", Index::Plain(I16, 1), vec![]),
            ],
            little().i16s([1, 2, 10]).bytes,
        ),
        // `a` has no samples here, and keeps its place; `c` follows `b`.
        segment(
            changes,
            vec![
                ("/'g'/'a'", Index::None, vec![Property::F64("gain", 2.0)]),
                ("/'g'/'c'", Index::Plain(F32, 2), vec![]),
            ],
            little().i16s([11]).f32s([0.5, 1.5]).bytes,
        ),
        // `a` again, as it was before, before `b` and `c`.
        segment(
            changes,
            vec![("/'g'/'a'", Index::AsBefore, vec![])],
            little().i16s([3, 4, 12]).f32s([2.5, 3.5]).bytes,
        ),
        // Another length of `b`.
        segment(
            changes,
            vec![("/'g'/'b'", Index::Plain(I16, 3), vec![])],
            little().i16s([5, 6, 13, 14, 15]).f32s([4.5, 5.5]).bytes,
        ),
        // A new list, of `c` as before and another type of `b`.
        segment(
            ALL,
            vec![
                ("/'g'/'c'", Index::AsBefore, vec![]),
                ("/'g'/'a'", Index::Plain(I16, 1), vec![]),
            ],
            little().f32s([6.5, 7.5]).i16s([7]).bytes,
        ),
        // Nothing but a property.
        segment(
            METADATA,
            vec![("/'g'/'a'", Index::None, vec![Property::F64("gain", 3.0)])],
            vec![],
        ),
    ]
    .iter()
    .flat_map(Segment::bytes)
    .collect()
}

fn without_metadata() -> Vec<u8> {
    let first = segment(
        ALL,
        vec![
            ("/'g'/'a'", Index::Plain(I16, 2), vec![]),
            ("/'g'/'b'", Index::Plain(I16, 1), vec![]),
        ],
        little().i16s([1, 2, 10]).bytes,
    );
    let mut bytes = first.bytes();
    for n in 0..20 {
        let samples = little().i16s([3 + 2 * n, 4 + 2 * n, 11 + n]);
        bytes.extend(segment(RAW, vec![], samples.bytes).bytes());
    }
    // Two chunks at once.
    let samples = little().i16s([43, 44, 31, 45, 46, 32]);
    bytes.extend(segment(RAW, vec![], samples.bytes).bytes());
    bytes
}

fn cut() -> Vec<u8> {
    let objects = vec![
        ("/'g'/'a'", Index::Plain(I16, 4), vec![]),
        ("/'g'/'b'", Index::Plain(F64, 4), vec![]),
    ];
    let whole = segment(
        ALL,
        objects.clone(),
        little().i16s(ramp(4)).f64s([0.0, 1.0, 2.0, 3.0]).bytes,
    );
    let last = little().i16s([1, 2, 3, 4]).f64s([9.0, 8.5]).add(&[1, 2, 3]);
    [
        whole.bytes(),
        segment(ALL, objects, last.bytes).unfinished(),
    ]
    .concat()
}

fn cut_interleaved() -> Vec<u8> {
    let mut bytes = interleaved(false);
    bytes.truncate(bytes.len() - 17);
    bytes
}

/// A finished segment of one and a half chunks: the half has half of each channel.
fn part_of_a_chunk() -> Vec<u8> {
    let objects = vec![
        ("/'g'/'a'", Index::Plain(I16, 4), vec![]),
        ("/'g'/'b'", Index::Plain(F64, 4), vec![]),
    ];
    let samples = little()
        .i16s([1, 2, 3, 4])
        .f64s([0.0, 1.0, 2.0, 3.0])
        .i16s([5, 6])
        .f64s([4.0, 5.0]);
    segment(ALL, objects, samples.bytes).bytes()
}

fn complex() -> Vec<u8> {
    let objects = vec![
        ("/'g'/'z'", Index::Plain(COMPLEX128, 2), vec![]),
        ("/'g'/'y'", Index::Plain(COMPLEX64, 3), vec![]),
    ];
    let samples = little()
        .f64s([1.0, -2.0, 0.1, 0.2])
        .f32s([1.5, 2.5, -3.5, 4.5, 0.1, 0.0]);
    segment(ALL, objects, samples.bytes).bytes()
}

fn times() -> Vec<u8> {
    let objects = vec![("/'g'/'t'", Index::Plain(TIME, 3), vec![])];
    let samples = (0..3_u64).fold(little(), |bytes, n| {
        let fraction = n << 62;
        bytes.u64(fraction).u64(3_850_000_000 + n)
    });
    segment(ALL, objects, samples.bytes).bytes()
}

/// Scale of a voltage: the stored number times a slope, in a chain as DAQmx writes it.
fn slope(slope: f64) -> Vec<Property> {
    vec![
        Property::U32("NI_Number_Of_Scales", 2),
        Property::Text("NI_Scaling_Status", "unscaled"),
        Property::Text("NI_Scale[1]_Scale_Type", "Linear"),
        Property::F64("NI_Scale[1]_Linear_Slope", slope),
        Property::F64("NI_Scale[1]_Linear_Y_Intercept", 0.125),
        Property::U32("NI_Scale[1]_Linear_Input_Source", 0),
    ]
}

/// Rows of an i16, an i32 and a u8 of a task, and a channel without a scale.
fn daqmx(is_big_endian: bool) -> Vec<u8> {
    let index = |scaler| Index::Daqmx {
        mark: 0x1269,
        values: 4,
        scalers: vec![scaler],
        widths: vec![8],
    };
    let mut samples = Bytes::new(is_big_endian);
    for n in 0..8_i16 {
        samples = samples.i16s([100 * n - 300]);
        samples = samples.add(&(70_000 * i32::from(n) - 5).to_le_bytes());
        samples = samples.add(&[n as u8 * 30]).add(&[0xee]);
    }
    Segment {
        mask: ALL | DAQMX_RAW,
        is_big_endian,
        objects: vec![
            ("/'task'/'ai0'", index(Scaler(3, 0, 0, 0)), slope(3.0e-4)),
            ("/'task'/'ai1'", index(Scaler(5, 0, 2, 0)), slope(-2.0e-9)),
            ("/'task'/'raw'", index(Scaler(0, 0, 6, 0)), {
                vec![Property::U32("NI_Number_Of_Scales", 1)]
            }),
        ],
        samples: samples.bytes,
    }
    .bytes()
}

fn daqmx_lines() -> Vec<u8> {
    let index = |bit| Index::Daqmx {
        mark: 0x126a,
        values: 6,
        scalers: vec![Scaler(0, 0, bit, 0)],
        widths: vec![2],
    };
    let properties = vec![Property::U32("NI_Number_Of_Scales", 1)];
    let samples: Vec<u8> = (0..12).map(|n: u8| n.wrapping_mul(91) ^ 0x5a).collect();
    let objects = vec![
        ("/'task'/'line0'", index(0), properties.clone()),
        ("/'task'/'line7'", index(7), properties.clone()),
        ("/'task'/'line11'", index(11), properties),
    ];
    segment(ALL | DAQMX_RAW, objects, samples).bytes()
}

/// Two cards with rates of their own: 4 rows of one, 2 of the other, in three chunks.
fn daqmx_two_buffers() -> Vec<u8> {
    let index = |values, scaler| Index::Daqmx {
        mark: 0x1269,
        values,
        scalers: vec![scaler],
        widths: vec![4, 2],
    };
    let mut samples = little();
    for chunk in 0..3 {
        for n in 0..4 {
            samples = samples.i16s([10 * chunk + n, -n]);
        }
        samples = samples.i16s([1000 + chunk, 2000 + chunk]);
    }
    let objects = vec![
        ("/'task'/'a'", index(4, Scaler(3, 0, 0, 0)), slope(1.0)),
        ("/'task'/'b'", index(4, Scaler(3, 0, 2, 0)), slope(2.0)),
        ("/'task'/'c'", index(2, Scaler(3, 1, 0, 0)), slope(3.0)),
    ];
    segment(ALL | DAQMX_RAW, objects, samples.bytes).bytes()
}

fn daqmx_cut() -> Vec<u8> {
    let mut bytes = daqmx(false);
    bytes.truncate(bytes.len() - 11);
    bytes
}

fn scales() -> Vec<u8> {
    let samples = little()
        .i16s(ramp(6))
        .i16s(ramp(6))
        .i16s(ramp(6))
        .i16s(ramp(6))
        .i16s(ramp(6));
    let no_index = 0xffff_ffff;
    let polynomial = vec![
        Property::U32("NI_Number_Of_Scales", 1),
        Property::Text("NI_Scale[0]_Scale_Type", "Polynomial"),
        Property::U32("NI_Scale[0]_Polynomial_Coefficients_Size", 3),
        Property::F64("NI_Scale[0]_Polynomial_Coefficients[0]", 1.0),
        Property::F64("NI_Scale[0]_Polynomial_Coefficients[1]", -0.5),
        Property::F64("NI_Scale[0]_Polynomial_Coefficients[2]", 0.01),
        Property::U32("NI_Scale[0]_Polynomial_Input_Source", no_index),
    ];
    let table = vec![
        Property::U32("NI_Number_Of_Scales", 1),
        Property::Text("NI_Scale[0]_Scale_Type", "Table"),
        Property::U32("NI_Scale[0]_Table_Scaled_Values_Size", 3),
        Property::F64("NI_Scale[0]_Table_Scaled_Values[0]", 5.0),
        Property::F64("NI_Scale[0]_Table_Scaled_Values[1]", 7.0),
        Property::F64("NI_Scale[0]_Table_Scaled_Values[2]", -1.0),
        Property::U32("NI_Scale[0]_Table_Pre_Scaled_Values_Size", 3),
        Property::F64("NI_Scale[0]_Table_Pre_Scaled_Values[0]", -70.0),
        Property::F64("NI_Scale[0]_Table_Pre_Scaled_Values[1]", -90.0),
        Property::F64("NI_Scale[0]_Table_Pre_Scaled_Values[2]", -95.0),
        Property::U32("NI_Scale[0]_Table_Input_Source", no_index),
    ];
    let sums = |kind: [&'static str; 3]| {
        vec![
            Property::U32("NI_Number_Of_Scales", 3),
            Property::Text("NI_Scale[0]_Scale_Type", "Linear"),
            Property::F64("NI_Scale[0]_Linear_Slope", 2.0),
            Property::F64("NI_Scale[0]_Linear_Y_Intercept", 1.0),
            Property::U32("NI_Scale[0]_Linear_Input_Source", no_index),
            Property::Text("NI_Scale[1]_Scale_Type", "AdvancedAPI"),
            Property::U32("NI_Scale[1]_AdvancedAPI_Input_Source", no_index),
            Property::Text("NI_Scale[2]_Scale_Type", kind[0]),
            Property::U32(kind[1], 0),
            Property::U32(kind[2], 1),
        ]
    };
    let add = [
        "Add",
        "NI_Scale[2]_Add_Left_Operand_Input_Source",
        "NI_Scale[2]_Add_Right_Operand_Input_Source",
    ];
    let subtract = [
        "Subtract",
        "NI_Scale[2]_Subtract_Left_Operand_Input_Source",
        "NI_Scale[2]_Subtract_Right_Operand_Input_Source",
    ];
    let mut done = slope(5.0);
    done[1] = Property::Text("NI_Scaling_Status", "scaled");
    let objects = vec![
        ("/'g'/'polynomial'", Index::Plain(I16, 6), polynomial),
        ("/'g'/'table'", Index::Plain(I16, 6), table),
        ("/'g'/'add'", Index::Plain(I16, 6), sums(add)),
        ("/'g'/'subtract'", Index::Plain(I16, 6), sums(subtract)),
        ("/'g'/'done'", Index::Plain(I16, 6), done),
    ];
    segment(ALL, objects, samples.bytes).bytes()
}

fn scales_of_group() -> Vec<u8> {
    let scale = vec![
        Property::Text("NI_Scale[0]_Scale_Type", "Linear"),
        Property::F64("NI_Scale[0]_Linear_Slope", 4.0),
        Property::F64("NI_Scale[0]_Linear_Y_Intercept", -1.0),
    ];
    let objects = vec![
        ("/'g'", Index::None, scale),
        ("/'g'/'a'", Index::Plain(I32, 2), vec![]),
        ("/'h'/'a'", Index::Plain(U8, 2), vec![]),
    ];
    let samples = little().u32(3).u32(u32::MAX).add(&[4]).add(&[255]);
    segment(ALL, objects, samples.bytes).bytes()
}

fn texts_between() -> Vec<u8> {
    let objects = vec![
        ("/'g'/'a'", Index::Plain(I16, 2), vec![]),
        (
            "/'g'/'log'",
            Index::Text {
                values: 2,
                bytes: 13,
            },
            vec![],
        ),
        ("/'g'/'b'", Index::Plain(I16, 2), vec![]),
    ];
    let mut samples = little().i16s([1, 2]).u32(2).u32(5).bytes;
    samples.extend(b"hithe");
    samples.extend(little().i16s([3, 4]).bytes);
    segment(ALL, objects, samples).bytes()
}
