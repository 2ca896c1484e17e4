//! A finger's recording, and files as other programs write them.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use import_look::guess;
use import_map::ImportMap;

pub const SECONDS: f64 = 3.2;

/// A touch with there and back at `speed_m_s` in strokes of `stroke_s`, from 0.6 s on.
#[derive(Clone, Copy)]
pub struct Finger {
    pub speed_m_s: f64,
    pub stroke_s: f64,
}

pub const FINGER: Finger = Finger {
    speed_m_s: 0.045,
    stroke_s: 1.0,
};

impl Finger {
    pub fn is_touching(t: f64) -> bool {
        (0.5..2.7).contains(&t)
    }

    pub fn position_m(self, t: f64) -> f64 {
        let phase = (t.clamp(0.6, 2.6) - 0.6) % (2.0 * self.stroke_s);
        let way = if phase < self.stroke_s {
            phase
        } else {
            2.0 * self.stroke_s - phase
        };
        0.02 + self.speed_m_s * way
    }

    pub fn velocity_m_s(self, t: f64) -> f64 {
        (self.position_m(t + 5e-4) - self.position_m(t - 5e-4)) / 1e-3
    }

    /// Normal and lateral force, N.
    pub fn forces_n(self, n: usize, t: f64) -> [f64; 2] {
        let touch = f64::from(u8::from(Self::is_touching(t)));
        let direction = (self.velocity_m_s(t) / self.speed_m_s).clamp(-1.0, 1.0);
        [
            0.7 * touch + 0.003 * noise(n),
            touch * direction * (0.35 - 0.15 * envelope(t)) + 0.003 * noise(n + 5),
        ]
    }
}

/// Values between −1 and 1 (Steele et al. 2014, SplitMix64).
pub fn noise(n: usize) -> f64 {
    let mut bits = (n as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((bits ^ (bits >> 31)) >> 33) as f64 / 2_f64.powi(30) - 1.0
}

pub fn envelope(t: f64) -> f64 {
    1.0 + 0.9 * (TAU * 8.0 * t).sin()
}

/// Drive in V and pickup in m, of a carrier.
pub fn electrical(n: usize, rate_hz: f64, carrier_hz: f64) -> [f64; 2] {
    let t = n as f64 / rate_hz;
    let damped = if Finger::is_touching(t) { 0.6 } else { 1.0 };
    let carrier = TAU * carrier_hz * t;
    [
        30.0 * envelope(t) * carrier.cos() + 1e-2 * noise(n),
        5e-7 * damped * envelope(t - 1.2e-3) * (carrier - 1.0).cos() + 1e-10 * noise(n + 3),
    ]
}

pub fn samples<T>(rate_hz: f64, value: impl Fn(usize, f64) -> T) -> Vec<T> {
    (0..(SECONDS * rate_hz) as usize)
        .map(|n| value(n, n as f64 / rate_hz))
        .collect()
}

/// A MATLAB file of version 4.
#[derive(Default)]
pub struct Matlab(pub Vec<u8>);

impl Matlab {
    pub fn add(&mut self, name: &str, values: &[f64]) {
        let header = [0, values.len() as u32, 1, 0, name.len() as u32 + 1];
        self.0
            .extend(header.iter().flat_map(|word| word.to_le_bytes()));
        self.0.extend(name.bytes().chain([0]));
        self.0
            .extend(values.iter().flat_map(|value| value.to_le_bytes()));
    }
}

/// Property of an object of a TDMS file.
pub enum Property {
    Number(&'static str, f64),
    Text(&'static str, &'static str),
}

pub enum TdmsValues {
    Integers(Vec<i16>),
    Floats(Vec<f64>),
}

/// A TDMS file of one segment.
#[derive(Default)]
pub struct Tdms {
    objects: Vec<u8>,
    count: u32,
    raw: Vec<u8>,
}

impl Tdms {
    pub fn text(bytes: &mut Vec<u8>, text: &str) {
        bytes.extend((text.len() as u32).to_le_bytes());
        bytes.extend(text.bytes());
    }

    pub fn add(&mut self, path: &str, values: &TdmsValues, properties: &[Property]) {
        let path: String = path.split('/').map(|part| format!("/'{part}'")).collect();
        Self::text(&mut self.objects, &path);
        let (kind, count) = match values {
            TdmsValues::Integers(values) => (2_u32, values.len()),
            TdmsValues::Floats(values) => (10, values.len()),
        };
        let words = [20, kind, 1];
        self.objects
            .extend(words.iter().flat_map(|word| word.to_le_bytes()));
        self.objects.extend((count as u64).to_le_bytes());
        match values {
            TdmsValues::Integers(values) => {
                self.raw
                    .extend(values.iter().flat_map(|value| value.to_le_bytes()));
            }
            TdmsValues::Floats(values) => {
                self.raw
                    .extend(values.iter().flat_map(|value| value.to_le_bytes()));
            }
        }
        self.objects.extend((properties.len() as u32).to_le_bytes());
        for property in properties {
            match property {
                Property::Number(name, value) => {
                    Self::text(&mut self.objects, name);
                    self.objects.extend(10_u32.to_le_bytes());
                    self.objects.extend(value.to_le_bytes());
                }
                Property::Text(name, value) => {
                    Self::text(&mut self.objects, name);
                    self.objects.extend(0x20_u32.to_le_bytes());
                    Self::text(&mut self.objects, value);
                }
            }
        }
        self.count += 1;
    }

    pub fn write(self, path: &Path) {
        let mut bytes = b"TDSm".to_vec();
        bytes.extend(0xE_u32.to_le_bytes());
        bytes.extend(4713_u32.to_le_bytes());
        let metadata = self.objects.len() + 4;
        bytes.extend(((metadata + self.raw.len()) as u64).to_le_bytes());
        bytes.extend((metadata as u64).to_le_bytes());
        bytes.extend(self.count.to_le_bytes());
        bytes.extend(self.objects);
        bytes.extend(self.raw);
        std::fs::write(path, bytes).unwrap();
    }
}

pub fn guessed(files: &[PathBuf]) -> (String, ImportMap) {
    let to = files[0].parent().unwrap().join("map.toml");
    let found = guess(files, &to, &mut |_| {}).unwrap();
    assert_eq!(found.unread, Vec::<String>::new());
    let text = std::fs::read_to_string(&to).unwrap();
    assert_eq!(text.matches("# CHECK: ").count(), found.checks, "{text}");
    let map = ImportMap::parse(&text, "map.toml").unwrap_or_else(|error| panic!("{error}\n{text}"));
    (text, map)
}

/// Returns the line of a key in a table of a map.
pub fn line<'a>(text: &'a str, table: &str, key: &str) -> &'a str {
    let start = text
        .find(&format!("[{table}]"))
        .unwrap_or_else(|| panic!("no [{table}] in\n{text}"));
    let lines = text[start..]
        .lines()
        .skip(1)
        .take_while(|line| !line.starts_with('['));
    let mut found = lines.filter(|line| line.starts_with(&format!("{key} = ")));
    found
        .next()
        .unwrap_or_else(|| panic!("no {key} in [{table}] of\n{text}"))
}

pub fn is_checked(line: &str) -> bool {
    line.contains("# CHECK")
}
