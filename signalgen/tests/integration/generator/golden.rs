//! Golden hashes of a seeded render: every bit of the samples must stay the same.

use signalgen::{
    ConverterSample, DriveCommand, DriveConfig, DriveSettings, Generator, SweepLaw, ToneList,
    Waveform,
};

/// Draws from a linear congruential generator.
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> u64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        self.0 >> 33
    }

    /// Returns a number from 0 to 1.
    fn fraction(&mut self) -> f64 {
        (self.next() % 10_000) as f64 / 10_000.0
    }

    fn waveform(&mut self) -> Waveform {
        let kind = self.next();
        let carrier_hz = 30_000.0 + 10_000.0 * self.fraction();
        let amplitude_v = 50.0 * self.fraction();
        match kind % 5 {
            0 => Waveform::Silence,
            1 => Waveform::Tone {
                carrier_hz,
                amplitude_v,
            },
            2 => Waveform::Modulated {
                carrier_hz,
                mean_amplitude_v: amplitude_v,
                modulation_hz: 1.0 + 20.0 * self.fraction(),
                modulation_index: self.fraction(),
                start_phase_rad: 6.0 * self.fraction(),
            },
            3 => Waveform::Sweep {
                from_hz: carrier_hz,
                to_hz: 30_000.0 + 9_000.0 * self.fraction(),
                duration_s: 0.001 + 0.02 * self.fraction(),
                law: if kind & 64 == 0 {
                    SweepLaw::Linear
                } else {
                    SweepLaw::Logarithmic
                },
                amplitude_v,
            },
            _ => Waveform::SteppedTones {
                tones: ToneList::new(&[carrier_hz, carrier_hz + 100.0, carrier_hz - 33.3]).unwrap(),
                dwell_s: 0.001 + 0.003 * self.fraction(),
                amplitude_v,
            },
        }
    }
}

/// 64-bit FNV-1a.
struct Fnv(u64);

impl Fnv {
    const fn new() -> Self {
        Self(0xCBF2_9CE4_8422_2325)
    }

    fn add(&mut self, value: u64) {
        for byte in value.to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x100_0000_01B3);
        }
    }
}

/// The hashes are from version 0.1.0, on x86-64 and on AArch64 with the GNU C library. Sines of other C libraries may differ in
/// the last bit.
#[test]
fn a_seeded_render_keeps_every_bit() {
    let settings = DriveSettings::new(DriveConfig {
        sample_rate_hz: 192_000,
        volts_per_unit: 100.0,
        limit_v: 100.0,
        ramp_s: 0.005,
    })
    .unwrap();
    let mut generator = Generator::new(settings);
    let mut draw = Draw(35_000);
    let (mut floats, mut i32s, mut i16s, mut states) =
        (Fnv::new(), Fnv::new(), Fnv::new(), Fnv::new());
    for _ in 0..300 {
        let program = settings.admit(draw.waveform()).unwrap();
        generator.apply(match draw.next() % 12 {
            0 => DriveCommand::Stop,
            1 => DriveCommand::EmergencyStop,
            2 | 3 => DriveCommand::Rearm,
            4 | 5 => DriveCommand::Adjust(program),
            _ => DriveCommand::Start(program),
        });
        let mut samples = vec![0.0_f32; 100 + (draw.next() % 9_000) as usize];
        generator.fill(&mut samples);
        for sample in samples {
            floats.add(u64::from(sample.to_bits()));
            i32s.add(i32::from_unit(sample) as u64);
            i16s.add(i16::from_unit(sample) as u64);
        }
        let state = generator.state();
        states.add(state.envelope_v.to_bits());
        states.add(state.carrier_hz.to_bits());
        states.add(state.frames);
    }
    assert_eq!(generator.state().frames, 1_390_890);
    assert_eq!(floats.0, 0xD52D_CB22_AC40_9351);
    assert_eq!(i32s.0, 0xE309_C7F8_6B2B_0821);
    assert_eq!(i16s.0, 0xAB64_C9EE_0783_EE83);
    assert_eq!(states.0, 0x8177_AFA8_BF2C_7346);
}
