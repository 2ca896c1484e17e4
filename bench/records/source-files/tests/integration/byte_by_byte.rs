//! Files written byte by byte: other byte orders, objects, cut ends, and kinds that are not read.

use std::fs;
use std::path::{Path, PathBuf};

use source_files::{Element, Format, SourceFile};

fn write(folder: &Path, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.join(name);
    fs::write(&path, bytes).unwrap();
    path
}

fn values(source: &mut SourceFile, name: &str) -> Vec<f64> {
    let vector = source
        .locate(name)
        .unwrap_or_else(|error| panic!("{error}"));
    let mut values = Vec::new();
    source
        .read(&vector, 0..vector.len(), &mut values)
        .unwrap_or_else(|error| panic!("{error}"));
    values
}

/// Writer of elements of MATLAB v5 in one byte order.
#[derive(Clone, Copy)]
struct Mat {
    is_big_endian: bool,
}

impl Mat {
    fn word(self, word: u32) -> [u8; 4] {
        if self.is_big_endian {
            word.to_be_bytes()
        } else {
            word.to_le_bytes()
        }
    }

    fn element(self, kind: u32, content: &[u8]) -> Vec<u8> {
        let mut bytes = [self.word(kind), self.word(content.len() as u32)].concat();
        bytes.extend(content);
        bytes.resize(bytes.len().next_multiple_of(8), 0);
        bytes
    }

    fn words(self, kind: u32, words: &[u32]) -> Vec<u8> {
        let content: Vec<u8> = words.iter().flat_map(|word| self.word(*word)).collect();
        self.element(kind, &content)
    }

    /// Returns an array of a class with the elements after its name.
    fn matrix(self, class: u32, shape: &[u32], name: &str, rest: &[Vec<u8>]) -> Vec<u8> {
        let head = [
            self.words(6, &[class, 0]),
            self.words(5, shape),
            self.element(1, name.as_bytes()),
        ];
        self.element(14, &[head.concat(), rest.concat()].concat())
    }

    fn doubles(self, name: &str, values: &[f64]) -> Vec<u8> {
        let bytes = values.iter().flat_map(|value| match self.is_big_endian {
            true => value.to_be_bytes(),
            false => value.to_le_bytes(),
        });
        let content = self.element(9, &bytes.collect::<Vec<u8>>());
        self.matrix(6, &[values.len() as u32, 1], name, &[content])
    }

    fn text(self, name: &str, text: &str) -> Vec<u8> {
        let content = self.element(16, text.as_bytes());
        self.matrix(4, &[1, text.len() as u32], name, &[content])
    }

    fn cells(self, name: &str, cells: &[Vec<u8>]) -> Vec<u8> {
        self.matrix(1, &[1, cells.len() as u32], name, cells)
    }

    fn object(self, name: &str, system: &str, class: &str, content: &[u8]) -> Vec<u8> {
        let head = [
            self.words(6, &[17, 0]),
            self.element(1, name.as_bytes()),
            self.element(1, system.as_bytes()),
            self.element(1, class.as_bytes()),
        ];
        self.element(14, &[head.concat(), content.to_vec()].concat())
    }

    /// Returns a reference to the object `id` of a class.
    fn reference(self, id: u32, class: u32) -> Vec<u8> {
        let words = self.words(6, &[0xdd00_0000, 2, 1, 1, id, class]);
        self.matrix(13, &[6, 1], "", &[words])
    }

    fn file(self, store_offset: u64, variables: &[Vec<u8>]) -> Vec<u8> {
        let mut bytes = b"MATLAB 5.0 MAT-file, written by a test".to_vec();
        bytes.resize(116, b' ');
        match self.is_big_endian {
            true => {
                bytes.extend(store_offset.to_be_bytes());
                bytes.extend(b"\x01\x00MI");
            }
            false => {
                bytes.extend(store_offset.to_le_bytes());
                bytes.extend(b"\x00\x01IM");
            }
        }
        [bytes, variables.concat()].concat()
    }
}

const LITTLE: Mat = Mat {
    is_big_endian: false,
};

/// Returns the table of classes, objects and properties: object `i + 1` has the properties `objects[i]`, a name and the
/// place of a value each.
fn object_table(names: &[&str], objects: &[&[(u32, u32)]]) -> Vec<u8> {
    let mut text: Vec<u8> = names
        .iter()
        .flat_map(|name| [name.as_bytes(), b"\0"].concat())
        .collect();
    text.resize(text.len().next_multiple_of(8), 0);
    // Class 1 has the last of the names.
    let classes = vec![0, 0, 0, 0, 0, names.len() as u32, 0, 0];
    let saved = vec![0u32; 2];
    let mut entries = vec![0u32; 6];
    let mut blocks = vec![0u32; 2];
    for (i, properties) in objects.iter().enumerate() {
        entries.extend([1, 0, 0, 0, i as u32 + 1, i as u32 + 1]);
        blocks.push(properties.len() as u32);
        blocks.extend(
            properties
                .iter()
                .flat_map(|(name, value)| [*name, 1, *value]),
        );
        blocks.resize(blocks.len().next_multiple_of(2), 0);
    }
    let mut offset = 40 + text.len();
    let mut offsets = vec![offset as u32];
    for part in [&classes, &saved, &entries, &blocks] {
        offset += 4 * part.len();
        offsets.push(offset as u32);
    }
    offsets.push(offset as u32);
    let head = [vec![4, names.len() as u32], offsets, vec![0, 0]].concat();
    let words = |words: &[u32]| {
        words
            .iter()
            .flat_map(|word| word.to_le_bytes())
            .collect::<Vec<u8>>()
    };
    let rest = [classes, saved, entries, blocks].concat();
    [words(&head), text, words(&rest)].concat()
}

/// Returns a file with a table `T`, a timetable `TT`, a map `M`, an object `P` and an object of Java.
fn file_with_objects() -> Vec<u8> {
    let mat = LITTLE;
    let names = [
        "data",
        "varnames",
        "any",
        "serialization",
        "Speed",
        "millis",
        "duration",
    ];
    let fields = |names: &[&str], fields: &[Vec<u8>]| {
        let list: Vec<u8> = names
            .iter()
            .flat_map(|name| {
                let mut bytes = name.as_bytes().to_vec();
                bytes.resize(16, 0);
                bytes
            })
            .collect();
        let head = [mat.words(5, &[16]), mat.element(1, &list)].concat();
        mat.matrix(2, &[1, 1], "", &[head, fields.concat()])
    };
    let texts = |texts: &[&str]| {
        let texts: Vec<_> = texts.iter().map(|text| mat.text("", text)).collect();
        mat.cells("", &texts)
    };
    let columns = mat.cells(
        "",
        &[
            mat.doubles("", &[1.0, 2.0]),
            mat.doubles("", &[-3.0, -4.0]),
            // An object within an object has no class of its own.
            mat.reference(5, 1),
        ],
    );
    let duration = mat.object("", "MCOS", "duration", &mat.reference(5, 1));
    let any = fields(
        &["data", "dimNames", "varNames", "rowTimes"],
        &[
            mat.cells("", &[mat.doubles("", &[7.0, 8.0])]),
            texts(&["When", "Variables"]),
            texts(&["Fn"]),
            duration,
        ],
    );
    let map = fields(
        &["keys", "values"],
        &[
            texts(&["rate", "x y"]),
            mat.cells(
                "",
                &[mat.doubles("", &[1000.0]), mat.doubles("", &[5.0, 6.0])],
            ),
        ],
    );
    // Values of properties, after the table and an empty cell.
    let cells = [
        mat.element(14, &[]),
        columns,
        texts(&["U", "F", "when"]),
        any,
        map,
        mat.doubles("", &[0.25]),
        mat.doubles("", &[500.0, 1500.0]),
    ];
    let table = object_table(
        &names,
        &[
            &[(1, 0), (2, 1)],
            &[(3, 2)],
            &[(4, 3)],
            &[(5, 4)],
            &[(6, 5)],
        ],
    );
    let table = mat.matrix(9, &[table.len() as u32, 1], "", &[mat.element(2, &table)]);
    let store = mat.cells("", &[vec![table], cells.to_vec()].concat());
    let wrapper = mat.object("", "MCOS", "FileWrapper__", &store);
    let list = {
        let mut name = b"MCOS".to_vec();
        name.resize(16, 0);
        [mat.words(5, &[16]), mat.element(1, &name)].concat()
    };
    let root = mat.matrix(2, &[1, 1], "", &[list, wrapper]);
    let inner = [b"\x00\x01IM\x00\x00\x00\x00".to_vec(), root].concat();
    let variables = [
        mat.object("T", "MCOS", "table", &mat.reference(1, 1)),
        mat.object("TT", "MCOS", "timetable", &mat.reference(2, 1)),
        mat.object("M", "MCOS", "containers.Map", &mat.reference(3, 1)),
        mat.object("P", "MCOS", "Rig", &mat.reference(4, 1)),
        mat.object("Q", "MCOS", "Unknown", &mat.reference(99, 1)),
        mat.object("J", "java", "java.util.Date", &[]),
    ];
    let store = mat.matrix(9, &[1, inner.len() as u32], "", &[mat.element(2, &inner)]);
    let offset = 128 + variables.concat().len() as u64;
    mat.file(offset, &[variables.concat(), store])
}

#[test]
fn tables_maps_and_objects_of_matlab_are_looked_into() {
    let folder = tempfile::tempdir().unwrap();
    let path = write(folder.path(), "objects.mat", &file_with_objects());
    let mut source = SourceFile::open(&path).unwrap();
    assert_eq!(values(&mut source, "T.U"), [1.0, 2.0]);
    assert_eq!(values(&mut source, "T.F"), [-3.0, -4.0]);
    assert_eq!(values(&mut source, "T.when"), [0.5, 1.5]);
    assert_eq!(values(&mut source, "TT.Fn"), [7.0, 8.0]);
    assert_eq!(values(&mut source, "TT.When"), [0.5, 1.5]);
    assert_eq!(source.scalar("M.rate").unwrap(), 1000.0);
    assert_eq!(values(&mut source, "M.x y"), [5.0, 6.0]);
    assert_eq!(source.scalar("P.Speed").unwrap(), 0.25);
    for (name, class) in [("Q", "`Unknown`"), ("J", "`java.util.Date (java)`")] {
        let error = source.locate(name).unwrap_err().to_string();
        assert!(
            error.contains(class) && error.contains("save it as an array of numbers"),
            "{error}"
        );
    }
}

#[test]
fn files_that_matlab_wrote_have_their_tables_and_times() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/matlab");
    let open = |file: &str| SourceFile::open(&folder.join(file)).unwrap();
    let mut tables = open("test_tables_v7.mat");
    assert_eq!(values(&mut tables, "table_numeric.Var1"), [1.1, 2.2, 3.3]);
    assert_eq!(
        values(&mut tables, "table_var_names.Y"),
        [100.0, 200.0, 300.0]
    );
    assert_eq!(
        values(&mut tables, "table_time.Duration"),
        [30.0, 60.0, 90.0]
    );
    let days = [18_262.0, 18_263.0, 18_264.0].map(|day| day * 86_400.0);
    assert_eq!(values(&mut tables, "table_time.Time"), days);
    assert_eq!(
        values(&mut tables, "table_multi_col_data.multicoldata[:,1]"),
        [4.0, 5.0, 6.0]
    );
    assert_eq!(
        values(&mut tables, "timetable_duration.Time"),
        [10.0, 20.0, 30.0]
    );
    assert_eq!(
        values(&mut tables, "timetable_var_names.Pressure"),
        [1.0, 2.0, 3.0]
    );
    let sampled = tables.locate("timetable_from_sample_rate.data1").unwrap();
    assert_eq!(sampled.rate_hz(), Some(10_000.0));
    let stepped = tables.locate("timetable_from_duration.data1").unwrap();
    assert_eq!(stepped.rate_hz(), Some(1.0));
    let late = tables
        .locate("timetable_from_starttime_duration.data1")
        .unwrap();
    assert_eq!((late.rate_hz(), late.start_s()), (Some(1.0), Some(10.0)));
    assert_eq!(
        tables.locate("timetable_with_attrs.data1").unwrap().unit(),
        Some("m/s")
    );
    let error = tables.locate("table_strings.Var1").unwrap_err().to_string();
    assert!(error.contains("an object of the class `string`"), "{error}");
    let mut maps = open("test_maps_v7.mat");
    assert_eq!(maps.scalar("map_char_keys.b").unwrap(), 2.0);
    let mut times = open("test_time_v7.mat");
    assert_eq!(times.scalar("dur_hms").unwrap(), 3723.0);
}

#[test]
fn matlab_files_of_both_byte_orders_are_read_and_their_cut_ends_named() {
    let folder = tempfile::tempdir().unwrap();
    for is_big_endian in [false, true] {
        let mat = Mat { is_big_endian };
        let bytes = mat.file(
            0,
            &[mat.doubles("a", &[1.0, 2.5]), mat.doubles("b", &[3.0; 9])],
        );
        let path = write(folder.path(), "x.mat", &bytes);
        let mut source = SourceFile::open(&path).unwrap();
        assert_eq!(values(&mut source, "a"), [1.0, 2.5]);
        assert_eq!(values(&mut source, "b"), [3.0; 9]);
        let path = write(folder.path(), "cut.mat", &bytes[..bytes.len() - 20]);
        let source = SourceFile::open(&path).unwrap();
        let refusal = source.locate("b").unwrap_err().to_string();
        assert!(
            refusal.contains("`b`, a variable within which the file ends"),
            "{refusal}"
        );
        assert!(source.locate("a").is_ok());
        assert!(
            source.notes()[0].contains("the file ends within the variable"),
            "{:?}",
            source.notes()
        );
    }
    // A compressed variable, in one stored block.
    let variable = LITTLE.doubles("a", &[1.0; 500]);
    let length = u16::try_from(variable.len()).unwrap();
    let mut packed = vec![0x78, 0x01, 0x01];
    packed.extend(length.to_le_bytes());
    packed.extend((!length).to_le_bytes());
    packed.extend(&variable);
    let mut element = [15u32, packed.len() as u32 + 4]
        .map(u32::to_le_bytes)
        .concat();
    element.extend(&packed);
    element.extend([0; 4]);
    let compressed = LITTLE.file(0, &[element]);
    for (end, words) in [
        (
            compressed.len() / 2,
            "`a`, a variable within which the file ends",
        ),
        (
            140,
            "the file ends within the variable that begins at byte 128: the file is damaged",
        ),
    ] {
        let path = write(folder.path(), "cut7.mat", &compressed[..end]);
        let error = match SourceFile::open(&path) {
            Ok(source) => source.locate("a").unwrap_err(),
            Err(error) => error,
        };
        assert!(error.to_string().contains(words), "{error}");
    }
    let mut header = LITTLE.file(0, &[]);
    let path = write(folder.path(), "empty.mat", &header);
    let error = SourceFile::open(&path).unwrap_err().to_string();
    assert!(
        error.contains("no array of numbers is in this MATLAB v5 file"),
        "{error}"
    );
    header.extend([0; 32]);
    let path = write(folder.path(), "zeros.mat", &header);
    let error = SourceFile::open(&path).unwrap_err().to_string();
    assert!(
        error.contains("byte 128: a variable should begin here"),
        "{error}"
    );
}

#[test]
fn big_endian_matrices_of_matlab_4_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let mut bytes: Vec<u8> = [1030u32, 3, 2, 0, 2]
        .into_iter()
        .flat_map(u32::to_be_bytes)
        .collect();
    bytes.extend(b"F\0");
    bytes.extend((1i16..=6).flat_map(i16::to_be_bytes));
    let path = write(folder.path(), "old.mat", &bytes);
    let mut source = SourceFile::open(&path).unwrap();
    assert_eq!(source.format(), Format::Matlab4);
    assert_eq!(
        source.arrays()[0].element,
        Element::Integer {
            bits: 16,
            is_signed: true
        }
    );
    assert_eq!(values(&mut source, "F[:,1]"), [4.0, 5.0, 6.0]);
    assert_eq!(values(&mut source, "F[1,:]"), [2.0, 5.0]);
    let path = write(folder.path(), "cut.mat", &bytes[..bytes.len() - 1]);
    let error = SourceFile::open(&path).unwrap_err().to_string();
    let words = "the file ends within the matrix that begins at byte 0: the file is damaged";
    assert!(error.contains(words), "{error}");
}

#[test]
fn a_cut_array_of_numpy_has_the_rows_that_are_there() {
    let folder = tempfile::tempdir().unwrap();
    let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (4, 2), }";
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend((0..7).flat_map(|i| f64::from(i).to_le_bytes()));
    let path = write(folder.path(), "cut.npy", &bytes);
    let mut source = SourceFile::open(&path).unwrap();
    assert_eq!(source.arrays()[0].shape, [3, 2]);
    assert_eq!(values(&mut source, "[:,1]"), [1.0, 3.0, 5.0]);
    assert!(
        source.notes()[0].contains("3 of 4 rows"),
        "{:?}",
        source.notes()
    );
    let place = bytes
        .windows(5)
        .position(|window| window == b"False")
        .unwrap();
    bytes[place..place + 5].copy_from_slice(b"True ");
    let path = write(folder.path(), "columns.npy", &bytes);
    let error = SourceFile::open(&path).unwrap_err().to_string();
    assert!(
        error.contains("56 bytes of elements are there of 64"),
        "{error}"
    );
}

#[test]
fn kinds_that_are_not_read_have_names_and_remedies() {
    let folder = tempfile::tempdir().unwrap();
    let zip = b"PK\x05\x06\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0";
    let pickled = {
        let header = "{'descr': '|O', 'fortran_order': False, 'shape': (1,), }";
        [
            b"\x93NUMPY\x01\x00",
            &(header.len() as u16).to_le_bytes()[..],
            header.as_bytes(),
            b"\x80\x04.",
        ]
        .concat()
    };
    for (name, bytes, words) in [
        (
            "a.tdms_index",
            &b"TDSh\x0e\0\0\0"[..],
            "index of a TDMS file",
        ),
        ("a.csv", b"", "an empty file"),
        ("a.npz", zip, "ZIP archive without NumPy's arrays"),
        ("a.xls", b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", "old Excel"),
        ("a.gz", b"\x1f\x8b\x08\0", "gzip"),
        ("a.aiff", b"FORM\0\0\0\0AIFF", "AIFF"),
        ("a.nc", b"CDF\x01\0\0\0\0", "netCDF"),
        (
            "a.bin",
            b"\x01\x02\x03\x04\x05\x06\x07\x08\x09",
            "01 02 03 04 05 06 07 08",
        ),
        ("a.wav", b"RIFF\x04\0\0\0WAVE", "fmt"),
        (
            "a.flac",
            b"fLaC\x80\0\0\x22",
            "description of the samples ends early",
        ),
        ("a.parquet", b"PAR1PAR1", "directory of its columns"),
        (
            "a.w64",
            b"riff\x2e\x91\xcf\x11\xa5\xd6\x28\xdb\x04\xc1\0\0",
            "header of 40 bytes",
        ),
    ] {
        let path = write(folder.path(), name, bytes);
        let error = SourceFile::open(&path).unwrap_err().to_string();
        assert!(error.contains(words) && error.contains(name), "{error}");
    }
    let path = write(folder.path(), "pickled.npy", &pickled);
    let source = SourceFile::open(&path).unwrap();
    let error = source.locate("[:]").unwrap_err().to_string();
    assert!(error.contains("object of Python"), "{error}");
    let error = SourceFile::open(folder.path()).unwrap_err().to_string();
    assert!(error.contains("folder"), "{error}");
}
