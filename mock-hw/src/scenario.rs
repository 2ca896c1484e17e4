//! The scenario file: what is true about the simulated bench and its participant.
//!
//! Everything has a default, so an empty file is the nominal bench of `Huloux 2021`, section "apparatus".
//! Nothing here is read by the bench: it knows only what its own configuration and calibration say.

use std::ops::RangeInclusive;

use serde::{Deserialize, Serialize};

use crate::seed;

/// Why a scenario file is refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ScenarioError {
    /// A key that no scenario has.
    #[error("line {line}: unknown key `{key}`{}", nearest.as_ref().map_or(String::new(), |n| format!("; did you mean `{n}`?")))]
    UnknownKey {
        /// The key as written.
        key: String,
        /// Its line, counted from 1.
        line: usize,
        /// The known key of that table that is spelt most like it.
        nearest: Option<String>,
    },
    /// Not TOML, or a value of the wrong type.
    #[error("line {line}: {message}")]
    Syntax {
        /// What the TOML reader says.
        message: String,
        /// The line, counted from 1.
        line: usize,
    },
    /// A value outside what the simulation can represent.
    #[error("`{key}` = {value} is outside {low} to {high}")]
    OutOfRange {
        /// Dotted path of the key.
        key: &'static str,
        /// The value given.
        value: f64,
        /// Least value allowed.
        low: f64,
        /// Greatest value allowed.
        high: f64,
    },
}

/// A simulated bench with its participant. All constants are the truth, not what the bench assumes.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Scenario {
    /// What the scenario is for, in one line.
    pub purpose: String,
    /// The glass plate and its actuators.
    pub plate: Plate,
    /// The amplifier between generator and actuators.
    pub amplifier: Amplifier,
    /// The pickup disc.
    pub pickup: Pickup,
    /// The sound card's inputs.
    pub converter: Converter,
    /// What lies between the program and the sound card.
    pub sound_layer: SoundLayer,
    /// The squeeze film and asperities, but for what belongs to a person.
    pub film: Film,
    /// The two-axis force sensor and its serial device.
    pub force_sensor: ForceSensor,
    /// Known masses that are placed on the plate, or hung over a pulley beside it.
    pub masses: Masses,
    /// The pulley encoder.
    pub encoder: Encoder,
    /// The person.
    pub participant: ParticipantScenario,
    /// How far the constants differ from seed to seed.
    pub jitter: Jitter,
}

/// The plate's carrier mode and a further one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Plate {
    /// Resonance of the carrier mode, Hz.
    pub resonance_hz: f64,
    /// Modal mass m_p, kg.
    pub modal_mass_kg: f64,
    /// Damping b_p, N·s/m.
    pub damping_n_s_per_m: f64,
    /// Force factor γ of the actuators on the carrier mode, N/V.
    pub force_factor_n_per_v: f64,
    /// A mode the bench's estimator does not know of.
    pub second_mode: SecondMode,
}

/// A further flexural mode; ratios are its mode shape relative to the carrier mode's.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SecondMode {
    /// Resonance, Hz.
    pub resonance_hz: f64,
    /// Modal mass, kg.
    pub modal_mass_kg: f64,
    /// Quality factor.
    pub quality: f64,
    /// At the actuators: multiplies γ.
    pub actuator_ratio: f64,
    /// At the pickup.
    pub pickup_ratio: f64,
    /// Under the finger.
    pub contact_ratio: f64,
}

/// Generator output to actuator voltage.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Amplifier {
    /// Actuator volts per full-scale unit of generator output, at frequencies far below the roll-off.
    pub volts_per_unit: f64,
    /// First-order roll-off, Hz.
    pub bandwidth_hz: f64,
    /// The amplifier stays enabled this long after a heartbeat edge, s.
    pub one_shot_s: f64,
    /// Its relay never opens, whatever enable, heartbeat and e-stop say.
    pub relay_welded: bool,
}

/// Plate displacement to sample value.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Pickup {
    /// Metres of plate displacement per sample value.
    pub metres_per_unit: f64,
    /// x̃ = metres_per_unit · sample · exp(+i·phase_rad) at the plate's resonance; a pure delay of phase_rad/ω.
    pub phase_rad: f64,
}

/// The sound card's inputs. Channel 0 reads the actuator voltage back, 1 the pickup, 2 the generator's output, others are quiet.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Converter {
    /// Number of input channels.
    pub channels: usize,
    /// Sample formats that it offers in either direction.
    pub formats: Vec<SampleFormat>,
    /// Actuator volts per sample value on channel 0.
    pub readback_volts_per_unit: f64,
    /// Resolution, bits; full scale is ±1.
    pub bits: u32,
    /// Magnitude at which the input clips.
    pub clip_units: f64,
    /// White noise, one-sided density, sample units per √Hz.
    pub noise_units_per_sqrt_hz: f64,
    /// Constant offset of every channel, sample units.
    pub offset_units: f64,
    /// Sensitivity of each channel relative to nominal; negative where its wires are exchanged; missing entries are 1.
    pub gains: Vec<f64>,
    /// Fraction of what channel 0 reads that leaks into the other channels.
    pub crosstalk: f64,
    /// How much later than nominal each channel samples, in samples; missing entries are 0.
    pub skew_samples: Vec<f64>,
    /// How much faster than nominal the sample clock runs, ppm.
    pub clock_ppm: f64,
}

/// Sample formats that a sound card may offer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[expect(missing_docs, reason = "the names say it")]
pub enum SampleFormat {
    F32,
    I32,
    I16,
    U8,
    I64,
}

/// What lies between the program and the sound card: a server or a plug-in that changes samples without a word.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SoundLayer {
    /// Rate that the output is brought down to and up from again, Hz; untouched when absent.
    pub rate_hz: Option<f64>,
    /// Whether what that rate cannot carry is filtered off before; it folds back otherwise.
    pub anti_alias: bool,
    /// Converter channel that each channel of the input stream carries; missing entries carry their own.
    pub inputs: Vec<usize>,
    /// A channel that falls behind the others.
    pub slip: Option<Slip>,
}

/// A channel of the input stream that falls behind, and stays there.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Slip {
    /// Channel of the input stream.
    pub channel: usize,
    /// By how many samples.
    pub samples: usize,
    /// When, s after the sound card was switched on or its rate set.
    pub after_s: f64,
}

/// Squeeze film and asperities (`Huloux 2021`, Eqs. 13–18).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Film {
    /// Ambient pressure p0, Pa.
    pub ambient_pressure_pa: f64,
    /// Apparent contact area S, m².
    pub contact_area_m2: f64,
    /// Roughness cut-off q0, rad/m (assumed: 2π over a 0.45 mm ridge).
    pub q0_rad_per_m: f64,
    /// Young's modulus E, Pa.
    pub youngs_modulus_pa: f64,
    /// Poisson's ratio ν.
    pub poisson_ratio: f64,
    /// Loss factor of the contact: b_c = η k_c/ω.
    pub loss_factor: f64,
    /// Time constant of levitation at a gap of 10 µm, s.
    pub lag_s: f64,
    /// The time constant goes as gap to this power.
    pub lag_gap_exponent: f64,
    /// Sliding distance over which friction builds up, m.
    pub presliding_m: f64,
}

/// Format of the force sensor's serial line (`docs/force-protocol.md`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ForceProtocol {
    /// Binary COBS frames.
    Frames,
    /// Lines of text.
    Lines,
}

/// The two-axis force sensor and its serial device.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ForceSensor {
    /// Samples per second of the device's own clock, Hz.
    pub rate_hz: f64,
    /// White noise per sample, N RMS, each axis.
    pub noise_n: f64,
    /// Mechanical resonance of the mount, Hz.
    pub resonance_hz: f64,
    /// Damping ratio of that resonance.
    pub damping_ratio: f64,
    /// Each axis saturates at ± this reading, N.
    pub range_n: f64,
    /// What the normal axis reads per newton on it.
    pub normal_gain: f64,
    /// What the lateral axis reads per newton on it.
    pub lateral_gain: f64,
    /// Reading of the normal axis without load, N.
    pub normal_offset_n: f64,
    /// Reading of the lateral axis without load, N.
    pub lateral_offset_n: f64,
    /// Steady drift of the normal axis, N/min.
    pub normal_drift_n_per_min: f64,
    /// Steady drift of the lateral axis, N/min.
    pub lateral_drift_n_per_min: f64,
    /// Standard deviation of the slow random drift of each axis beside it, N.
    pub wander_n: f64,
    /// Correlation time of that wander, s.
    pub wander_time_s: f64,
    /// Creep: share of a load that its reading still gains, and keeps for as long when the load is gone.
    pub creep: f64,
    /// Time constant of creep, s.
    pub creep_time_s: f64,
    /// Fraction of the lateral force that the normal axis reads.
    pub lateral_to_normal: f64,
    /// Fraction of the normal force that the lateral axis reads.
    pub normal_to_lateral: f64,
    /// How much faster than true time the device's clock runs, ppm.
    pub clock_ppm: f64,
    /// Samples leave the device in bursts of this period, s.
    pub burst_period_s: f64,
    /// What is spoken on the serial line.
    pub protocol: ForceProtocol,
}

/// Known masses: on the plate they press, over the pulley they pull towards increasing position. They load the sensor but not
/// the plate's vibration: they are for a plate at rest.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Masses {
    /// Acceleration of gravity where the bench stands, m/s².
    pub gravity_m_per_s2: f64,
    /// Standard deviation of a mass from what is written on it, relative.
    pub error: f64,
    /// How much lower the plate lies at increasing position, rad; the string to the pulley stays level.
    pub tilt_rad: f64,
    /// Share of the pull that the pulley keeps for itself.
    pub pulley_friction: f64,
    /// A mass placed on the plate bounces at this frequency, Hz.
    pub bounce_hz: f64,
    /// Time constant in which that dies down, s.
    pub bounce_time_s: f64,
    /// A mass on its string swings at this frequency, Hz.
    pub swing_hz: f64,
    /// Time constant in which that dies down, s.
    pub swing_time_s: f64,
}

/// The pulley encoder.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Encoder {
    /// Quadrature counts per metre of finger travel.
    pub counts_per_m: f64,
}

/// The person: pinned values, or drawn by seed from the population.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ParticipantScenario {
    /// Asperity scale σ_t, m; drawn when absent.
    pub sigma_t_m: Option<f64>,
    /// Tissue impedance Z_t at the plate's resonance, real and imaginary part, N·s/m; drawn when absent.
    pub z_t_n_s_per_m: Option<[f64; 2]>,
    /// Friction coefficient without vibration; drawn when absent.
    pub mu0: Option<f64>,
    /// What is drawn from.
    pub population: Population,
    /// Slow change of the skin within a session.
    pub moisture: Moisture,
    /// How the person moves and presses.
    pub behaviour: Behaviour,
}

/// Distributions of the skin (`Huloux 2021`, section on participants; μ0's mean and spread are assumptions).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Population {
    /// Mean and standard deviation of σ_t, m.
    pub sigma_t_m: [f64; 2],
    /// Mean and standard deviation of Re Z_t, N·s/m; never below 0.05.
    pub re_z_t_n_s_per_m: [f64; 2],
    /// Mean and standard deviation of Im Z_t, N·s/m; never below 0.5.
    pub im_z_t_n_s_per_m: [f64; 2],
    /// Mean and standard deviation of μ0; never outside 0.2 to 1.8.
    pub mu0: [f64; 2],
    /// Spearman correlation of μ0 with Im Z_t.
    pub spearman_mu0_im_z_t: f64,
}

/// Moisture of the skin: one slow random walk about its mean that moves σ_t, Z_t and μ0 together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Moisture {
    /// Standard deviation of the relative change of μ0; Z_t changes by −0.7 and σ_t by −0.3 of it.
    pub relative_sd: f64,
    /// Correlation time, s.
    pub time_s: f64,
}

/// How the person moves and presses. Probabilities are per exploration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Behaviour {
    /// Normal force aimed at when no band is shown, N.
    pub force_aim_n: f64,
    /// Standard deviation of the person's initial misjudgement of force, relative.
    pub force_misjudgement: f64,
    /// Share of a shown force error that is corrected in the next exploration.
    pub force_learning: f64,
    /// Standard deviation of slow force wander, N.
    pub force_drift_n: f64,
    /// Correlation time of that wander, s.
    pub force_drift_time_s: f64,
    /// RMS of force tremor (8–12 Hz), N.
    pub tremor_n: f64,
    /// RMS of position tremor, m.
    pub tremor_m: f64,
    /// Mean reaction time to what is seen or heard, s.
    pub reaction_s: f64,
    /// Standard deviation of the person's constant speed error, relative.
    pub speed_error: f64,
    /// RMS of fluctuating speed error, relative.
    pub speed_wander: f64,
    /// Bandwidth of the hand's tracking loop, Hz.
    pub tracking_hz: f64,
    /// Probability of starting late.
    pub late_start_probability: f64,
    /// Extra reaction time of a late start, s.
    pub late_start_s: f64,
    /// Probability of lifting off during an exploration.
    pub lift_off_probability: f64,
    /// How long such a lift lasts, s.
    pub lift_off_s: f64,
    /// Rests the finger on the plate while nothing is asked.
    pub rests_unasked: bool,
}

/// Spread of the true constants from seed to seed. Off by default.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Jitter {
    /// Whether [`Scenario::realised`] changes anything.
    pub enabled: bool,
    /// Pickup sensitivity, ± relative.
    pub pickup_sensitivity: f64,
    /// Pickup phase, ± rad.
    pub pickup_phase_rad: f64,
    /// Plate resonance, ± Hz.
    pub resonance_hz: f64,
    /// Quality factor of the carrier mode, from and to.
    pub quality: [f64; 2],
    /// Force factor, ± relative.
    pub force_factor: f64,
    /// Skew of each channel but the first, 0 to this many samples.
    pub skew_samples: f64,
    /// Gain of each axis of the force sensor, ± relative.
    pub force_gain: f64,
    /// Crosstalk between its axes, ± fraction.
    pub force_crosstalk: f64,
    /// Readings without load, ± N.
    pub force_offset_n: f64,
    /// Steady drift of each axis, ± N/min.
    pub force_drift_n_per_min: f64,
    /// Share that the pulley keeps, 0 to this.
    pub pulley_friction: f64,
}

impl Default for Plate {
    fn default() -> Self {
        Self {
            resonance_hz: 35_000.0,
            modal_mass_kg: 0.008,
            damping_n_s_per_m: 7.01,
            force_factor_n_per_v: 0.13,
            second_mode: SecondMode::default(),
        }
    }
}

impl Default for SecondMode {
    fn default() -> Self {
        Self {
            resonance_hz: 41_200.0,
            modal_mass_kg: 0.02,
            quality: 180.0,
            actuator_ratio: 0.6,
            pickup_ratio: 0.7,
            contact_ratio: 0.8,
        }
    }
}

impl Default for Amplifier {
    fn default() -> Self {
        Self {
            volts_per_unit: 60.0,
            bandwidth_hz: 200_000.0,
            one_shot_s: 0.1,
            relay_welded: false,
        }
    }
}

impl Default for Pickup {
    fn default() -> Self {
        Self {
            metres_per_unit: 5.0e-6,
            phase_rad: 0.2,
        }
    }
}

impl Default for Converter {
    fn default() -> Self {
        Self {
            channels: 4,
            formats: vec![SampleFormat::F32, SampleFormat::I32, SampleFormat::I16],
            readback_volts_per_unit: 60.0,
            bits: 24,
            clip_units: 1.0,
            noise_units_per_sqrt_hz: 3.0e-8,
            offset_units: 0.0,
            gains: Vec::new(),
            crosstalk: 1.0e-4,
            skew_samples: Vec::new(),
            clock_ppm: 0.0,
        }
    }
}

impl Default for SoundLayer {
    fn default() -> Self {
        Self {
            rate_hz: None,
            anti_alias: true,
            inputs: Vec::new(),
            slip: None,
        }
    }
}

impl Default for Film {
    fn default() -> Self {
        Self {
            ambient_pressure_pa: 101_325.0,
            contact_area_m2: 300.0e-6,
            q0_rad_per_m: 1.4e4,
            youngs_modulus_pa: 20.0e6,
            poisson_ratio: 0.5,
            loss_factor: 0.3,
            lag_s: 1.0e-3,
            lag_gap_exponent: 0.2,
            presliding_m: 0.3e-3,
        }
    }
}

impl Default for ForceSensor {
    fn default() -> Self {
        Self {
            rate_hz: 10_000.0,
            noise_n: 0.002,
            resonance_hz: 3_000.0,
            damping_ratio: 0.4,
            range_n: 10.0,
            normal_gain: 1.0,
            lateral_gain: 1.0,
            normal_offset_n: 0.0,
            lateral_offset_n: 0.0,
            normal_drift_n_per_min: 0.0,
            lateral_drift_n_per_min: 0.0,
            wander_n: 0.0,
            wander_time_s: 20.0,
            creep: 0.0,
            creep_time_s: 30.0,
            lateral_to_normal: 0.0,
            normal_to_lateral: 0.0,
            clock_ppm: 30.0,
            burst_period_s: 0.004,
            protocol: ForceProtocol::Frames,
        }
    }
}

impl Default for Masses {
    fn default() -> Self {
        Self {
            gravity_m_per_s2: 9.806_65,
            error: 5.0e-5,
            tilt_rad: 0.0,
            pulley_friction: 0.0,
            bounce_hz: 12.0,
            bounce_time_s: 0.08,
            swing_hz: 2.5,
            swing_time_s: 0.2,
        }
    }
}

impl Default for Encoder {
    fn default() -> Self {
        Self {
            counts_per_m: 40_000.0,
        }
    }
}

impl Default for Population {
    fn default() -> Self {
        Self {
            sigma_t_m: [1.7e-6, 0.4e-6],
            re_z_t_n_s_per_m: [0.47, 0.28],
            im_z_t_n_s_per_m: [3.16, 0.63],
            mu0: [0.8, 0.2],
            spearman_mu0_im_z_t: -0.58,
        }
    }
}

impl Default for Moisture {
    fn default() -> Self {
        Self {
            relative_sd: 0.03,
            time_s: 20.0,
        }
    }
}

impl Default for Behaviour {
    fn default() -> Self {
        Self {
            force_aim_n: 0.65,
            force_misjudgement: 0.15,
            force_learning: 0.7,
            force_drift_n: 0.03,
            force_drift_time_s: 1.0,
            tremor_n: 0.008,
            tremor_m: 15.0e-6,
            reaction_s: 0.22,
            speed_error: 0.02,
            speed_wander: 0.02,
            tracking_hz: 2.0,
            late_start_probability: 0.03,
            late_start_s: 0.6,
            lift_off_probability: 0.02,
            lift_off_s: 0.2,
            rests_unasked: false,
        }
    }
}

impl Default for Jitter {
    fn default() -> Self {
        Self {
            enabled: false,
            pickup_sensitivity: 0.2,
            pickup_phase_rad: 0.5,
            resonance_hz: 300.0,
            quality: [150.0, 350.0],
            force_factor: 0.2,
            skew_samples: 1.0,
            force_gain: 0.2,
            force_crosstalk: 0.05,
            force_offset_n: 0.03,
            force_drift_n_per_min: 0.005,
            pulley_friction: 0.003,
        }
    }
}

impl Plate {
    /// Angular resonance of the carrier mode, rad/s.
    #[must_use]
    pub fn omega_rad_per_s(&self) -> f64 {
        std::f64::consts::TAU * self.resonance_hz
    }
}

impl Scenario {
    /// Reads a scenario strictly: an unknown key or a value out of range is an error that names it.
    ///
    /// # Errors
    /// [`ScenarioError`] says which key on which line and what is allowed.
    pub fn parse(text: &str) -> Result<Self, ScenarioError> {
        let scenario: Self = toml::from_str(text).map_err(|e| explain(text, &e))?;
        scenario.check()?;
        Ok(scenario)
    }

    /// The scenario with its constants jittered by `seed`; unchanged unless `jitter.enabled`, which it no longer is.
    #[must_use]
    pub fn realised(&self, seed: u64) -> Self {
        use rand::RngExt;
        let mut out = self.clone();
        let j = &self.jitter;
        if !j.enabled {
            return out;
        }
        out.jitter.enabled = false;
        let mut rng = seed::stream(seed, seed::Stream::Jitter);
        let mut within = |half_width: f64| half_width * (2.0 * rng.random::<f64>() - 1.0);
        out.pickup.metres_per_unit *= 1.0 + within(j.pickup_sensitivity);
        out.pickup.phase_rad += within(j.pickup_phase_rad);
        out.plate.resonance_hz += within(j.resonance_hz);
        let [low, high] = j.quality;
        let quality = 0.5 * (low + high) + within(0.5 * (high - low));
        out.plate.damping_n_s_per_m =
            out.plate.omega_rad_per_s() * out.plate.modal_mass_kg / quality;
        out.plate.force_factor_n_per_v *= 1.0 + within(j.force_factor);
        let half = 0.5 * j.skew_samples;
        out.converter.skew_samples = (0..self.converter.channels)
            .map(|ch| {
                let drawn = half + within(half);
                self.converter.skew(ch) + if ch == 0 { 0.0 } else { drawn }
            })
            .collect();
        let force = &mut out.force_sensor;
        force.normal_gain *= 1.0 + within(j.force_gain);
        force.lateral_gain *= 1.0 + within(j.force_gain);
        force.lateral_to_normal += within(j.force_crosstalk);
        force.normal_to_lateral += within(j.force_crosstalk);
        force.normal_offset_n += within(j.force_offset_n);
        force.lateral_offset_n += within(j.force_offset_n);
        force.normal_drift_n_per_min += within(j.force_drift_n_per_min);
        force.lateral_drift_n_per_min += within(j.force_drift_n_per_min);
        let half = 0.5 * j.pulley_friction;
        out.masses.pulley_friction += half + within(half);
        out
    }

    fn check(&self) -> Result<(), ScenarioError> {
        let p = &self.plate;
        let (m2, amp, con, film) = (&p.second_mode, &self.amplifier, &self.converter, &self.film);
        let (force, who) = (&self.force_sensor, &self.participant);
        let (pop, b, jit) = (&who.population, &who.behaviour, &self.jitter);
        in_range("plate.resonance_hz", p.resonance_hz, 20e3..=45e3)?;
        in_range("plate.modal_mass_kg", p.modal_mass_kg, 1e-4..=1.0)?;
        in_range("plate.damping_n_s_per_m", p.damping_n_s_per_m, 0.01..=1e3)?;
        in_range(
            "plate.force_factor_n_per_v",
            p.force_factor_n_per_v,
            1e-4..=10.0,
        )?;
        in_range(
            "plate.second_mode.resonance_hz",
            m2.resonance_hz,
            5e3..=80e3,
        )?;
        in_range(
            "plate.second_mode.modal_mass_kg",
            m2.modal_mass_kg,
            1e-4..=1.0,
        )?;
        in_range("plate.second_mode.quality", m2.quality, 1.0..=1e4)?;
        in_range(
            "plate.second_mode.actuator_ratio",
            m2.actuator_ratio,
            -2.0..=2.0,
        )?;
        in_range(
            "plate.second_mode.pickup_ratio",
            m2.pickup_ratio,
            -2.0..=2.0,
        )?;
        in_range(
            "plate.second_mode.contact_ratio",
            m2.contact_ratio,
            -2.0..=2.0,
        )?;
        in_range("amplifier.volts_per_unit", amp.volts_per_unit, 0.1..=1e3)?;
        in_range("amplifier.bandwidth_hz", amp.bandwidth_hz, 40e3..=10e6)?;
        in_range("amplifier.one_shot_s", amp.one_shot_s, 1e-3..=0.1)?;
        in_range(
            "pickup.metres_per_unit",
            self.pickup.metres_per_unit,
            1e-9..=1e-3,
        )?;
        in_range("pickup.phase_rad", self.pickup.phase_rad, -3.15..=3.15)?;
        in_range("converter.channels", con.channels as f64, 2.0..=32.0)?;
        in_range(
            "converter.readback_volts_per_unit",
            con.readback_volts_per_unit,
            0.1..=1e4,
        )?;
        in_range("converter.bits", f64::from(con.bits), 8.0..=32.0)?;
        in_range("converter.clip_units", con.clip_units, 1e-3..=1.0)?;
        in_range(
            "converter.noise_units_per_sqrt_hz",
            con.noise_units_per_sqrt_hz,
            0.0..=1e-3,
        )?;
        in_range("converter.offset_units", con.offset_units, -1.0..=1.0)?;
        in_range("converter.crosstalk", con.crosstalk, -1.0..=1.0)?;
        for &gain in &con.gains {
            in_range("converter.gains", gain, -100.0..=100.0)?;
        }
        in_range(
            "converter.gains (entries)",
            con.gains.len() as f64,
            0.0..=con.channels as f64,
        )?;
        in_range(
            "converter.formats (entries)",
            con.formats.len() as f64,
            1.0..=5.0,
        )?;
        for &skew in &con.skew_samples {
            in_range("converter.skew_samples", skew, -4.0..=4.0)?;
        }
        in_range(
            "converter.skew_samples (entries)",
            con.skew_samples.len() as f64,
            0.0..=con.channels as f64,
        )?;
        in_range("converter.clock_ppm", con.clock_ppm, -1e3..=1e3)?;
        self.sound_layer.check(con.channels)?;
        in_range(
            "film.ambient_pressure_pa",
            film.ambient_pressure_pa,
            1e3..=1e6,
        )?;
        in_range("film.contact_area_m2", film.contact_area_m2, 10e-6..=1e-3)?;
        in_range("film.q0_rad_per_m", film.q0_rad_per_m, 1e3..=1e6)?;
        in_range("film.youngs_modulus_pa", film.youngs_modulus_pa, 1e5..=1e9)?;
        in_range("film.poisson_ratio", film.poisson_ratio, 0.0..=0.5)?;
        in_range("film.loss_factor", film.loss_factor, 0.0..=1.0)?;
        in_range("film.lag_s", film.lag_s, 2e-4..=0.1)?;
        in_range("film.lag_gap_exponent", film.lag_gap_exponent, -1.0..=1.0)?;
        in_range("film.presliding_m", film.presliding_m, 1e-5..=5e-3)?;
        in_range("force_sensor.rate_hz", force.rate_hz, 500.0..=20e3)?;
        in_range("force_sensor.noise_n", force.noise_n, 0.0..=1.0)?;
        in_range(
            "force_sensor.resonance_hz",
            force.resonance_hz,
            100.0..=20e3,
        )?;
        in_range(
            "force_sensor.damping_ratio",
            force.damping_ratio,
            0.05..=2.0,
        )?;
        in_range("force_sensor.range_n", force.range_n, 0.1..=1e3)?;
        in_range("force_sensor.normal_gain", force.normal_gain, -10.0..=10.0)?;
        in_range(
            "force_sensor.lateral_gain",
            force.lateral_gain,
            -10.0..=10.0,
        )?;
        for (key, drift) in [
            (
                "force_sensor.normal_drift_n_per_min",
                force.normal_drift_n_per_min,
            ),
            (
                "force_sensor.lateral_drift_n_per_min",
                force.lateral_drift_n_per_min,
            ),
        ] {
            in_range(key, drift, -10.0..=10.0)?;
        }
        in_range("force_sensor.wander_n", force.wander_n, 0.0..=1.0)?;
        in_range("force_sensor.wander_time_s", force.wander_time_s, 0.1..=1e4)?;
        in_range("force_sensor.creep", force.creep, 0.0..=0.2)?;
        in_range("force_sensor.creep_time_s", force.creep_time_s, 0.1..=1e4)?;
        let masses = &self.masses;
        in_range(
            "masses.gravity_m_per_s2",
            masses.gravity_m_per_s2,
            9.76..=9.84,
        )?;
        in_range("masses.error", masses.error, 0.0..=0.1)?;
        in_range("masses.tilt_rad", masses.tilt_rad, -0.2..=0.2)?;
        in_range("masses.pulley_friction", masses.pulley_friction, 0.0..=0.5)?;
        in_range("masses.bounce_hz", masses.bounce_hz, 0.5..=100.0)?;
        in_range("masses.bounce_time_s", masses.bounce_time_s, 0.01..=100.0)?;
        in_range("masses.swing_hz", masses.swing_hz, 0.5..=100.0)?;
        in_range("masses.swing_time_s", masses.swing_time_s, 0.01..=100.0)?;
        in_range(
            "force_sensor.normal_offset_n",
            force.normal_offset_n,
            -10.0..=10.0,
        )?;
        in_range(
            "force_sensor.lateral_offset_n",
            force.lateral_offset_n,
            -10.0..=10.0,
        )?;
        in_range(
            "force_sensor.lateral_to_normal",
            force.lateral_to_normal,
            -0.5..=0.5,
        )?;
        in_range(
            "force_sensor.normal_to_lateral",
            force.normal_to_lateral,
            -0.5..=0.5,
        )?;
        in_range("force_sensor.clock_ppm", force.clock_ppm, -1e3..=1e3)?;
        in_range(
            "force_sensor.burst_period_s",
            force.burst_period_s,
            1e-4..=0.1,
        )?;
        in_range("encoder.counts_per_m", self.encoder.counts_per_m, 1e3..=1e7)?;
        if let Some(sigma) = who.sigma_t_m {
            in_range("participant.sigma_t_m", sigma, 0.3e-6..=6e-6)?;
        }
        if let Some([re, im]) = who.z_t_n_s_per_m {
            in_range("participant.z_t_n_s_per_m (real)", re, 0.05..=100.0)?;
            in_range("participant.z_t_n_s_per_m (imaginary)", im, 0.5..=100.0)?;
        }
        if let Some(mu0) = who.mu0 {
            in_range("participant.mu0", mu0, 0.05..=3.0)?;
        }
        for (key, [mean, sd], range) in [
            (
                "participant.population.sigma_t_m",
                pop.sigma_t_m,
                0.5e-6..=4e-6,
            ),
            (
                "participant.population.re_z_t_n_s_per_m",
                pop.re_z_t_n_s_per_m,
                0.1..=50.0,
            ),
            (
                "participant.population.im_z_t_n_s_per_m",
                pop.im_z_t_n_s_per_m,
                1.0..=50.0,
            ),
            ("participant.population.mu0", pop.mu0, 0.3..=1.5),
        ] {
            in_range(key, mean, range)?;
            in_range(key, sd, 0.0..=mean)?;
        }
        in_range(
            "participant.population.spearman_mu0_im_z_t",
            pop.spearman_mu0_im_z_t,
            -1.0..=1.0,
        )?;
        in_range(
            "participant.moisture.relative_sd",
            who.moisture.relative_sd,
            0.0..=0.2,
        )?;
        in_range(
            "participant.moisture.time_s",
            who.moisture.time_s,
            0.1..=1e4,
        )?;
        in_range(
            "participant.behaviour.force_aim_n",
            b.force_aim_n,
            0.05..=5.0,
        )?;
        in_range(
            "participant.behaviour.force_misjudgement",
            b.force_misjudgement,
            0.0..=1.0,
        )?;
        in_range(
            "participant.behaviour.force_learning",
            b.force_learning,
            0.0..=1.0,
        )?;
        in_range(
            "participant.behaviour.force_drift_n",
            b.force_drift_n,
            0.0..=1.0,
        )?;
        in_range(
            "participant.behaviour.force_drift_time_s",
            b.force_drift_time_s,
            0.01..=1e3,
        )?;
        in_range("participant.behaviour.tremor_n", b.tremor_n, 0.0..=1.0)?;
        in_range("participant.behaviour.tremor_m", b.tremor_m, 0.0..=1e-3)?;
        in_range("participant.behaviour.reaction_s", b.reaction_s, 0.05..=2.0)?;
        in_range(
            "participant.behaviour.speed_error",
            b.speed_error,
            0.0..=0.5,
        )?;
        in_range(
            "participant.behaviour.speed_wander",
            b.speed_wander,
            0.0..=0.5,
        )?;
        in_range(
            "participant.behaviour.tracking_hz",
            b.tracking_hz,
            0.2..=10.0,
        )?;
        in_range(
            "participant.behaviour.late_start_probability",
            b.late_start_probability,
            0.0..=1.0,
        )?;
        in_range(
            "participant.behaviour.late_start_s",
            b.late_start_s,
            0.0..=10.0,
        )?;
        in_range(
            "participant.behaviour.lift_off_probability",
            b.lift_off_probability,
            0.0..=1.0,
        )?;
        in_range("participant.behaviour.lift_off_s", b.lift_off_s, 0.0..=10.0)?;
        in_range(
            "jitter.pickup_sensitivity",
            jit.pickup_sensitivity,
            0.0..=0.9,
        )?;
        in_range("jitter.pickup_phase_rad", jit.pickup_phase_rad, 0.0..=3.15)?;
        in_range("jitter.resonance_hz", jit.resonance_hz, 0.0..=3e3)?;
        in_range("jitter.quality", jit.quality[0], 10.0..=jit.quality[1])?;
        in_range("jitter.quality", jit.quality[1], jit.quality[0]..=1e4)?;
        in_range("jitter.force_factor", jit.force_factor, 0.0..=0.9)?;
        in_range("jitter.skew_samples", jit.skew_samples, 0.0..=4.0)?;
        in_range("jitter.force_gain", jit.force_gain, 0.0..=0.9)?;
        in_range("jitter.force_crosstalk", jit.force_crosstalk, 0.0..=0.3)?;
        in_range("jitter.force_offset_n", jit.force_offset_n, 0.0..=5.0)?;
        in_range(
            "jitter.force_drift_n_per_min",
            jit.force_drift_n_per_min,
            0.0..=1.0,
        )?;
        in_range("jitter.pulley_friction", jit.pulley_friction, 0.0..=0.3)
    }
}

impl ForceSensor {
    /// What the axes read, normal and lateral, of forces that act on them: a matrix in rows, dimensionless.
    #[must_use]
    pub fn response(&self) -> [[f64; 2]; 2] {
        let (normal, lateral) = (self.normal_gain, self.lateral_gain);
        [
            [normal, normal * self.lateral_to_normal],
            [lateral * self.normal_to_lateral, lateral],
        ]
    }
}

impl SoundLayer {
    fn check(&self, channels: usize) -> Result<(), ScenarioError> {
        let last = channels.saturating_sub(1) as f64;
        if let Some(rate_hz) = self.rate_hz {
            in_range("sound_layer.rate_hz", rate_hz, 8e3..=192e3)?;
        }
        in_range(
            "sound_layer.inputs (entries)",
            self.inputs.len() as f64,
            0.0..=channels as f64,
        )?;
        for &input in &self.inputs {
            in_range("sound_layer.inputs", input as f64, 0.0..=last)?;
        }
        if let Some(slip) = &self.slip {
            in_range("sound_layer.slip.channel", slip.channel as f64, 0.0..=last)?;
            in_range("sound_layer.slip.samples", slip.samples as f64, 1.0..=16.0)?;
            in_range("sound_layer.slip.after_s", slip.after_s, 0.0..=1e4)?;
        }
        Ok(())
    }
}

impl Converter {
    /// Sensitivity of channel `index` relative to nominal.
    #[must_use]
    pub fn gain(&self, index: usize) -> f64 {
        self.gains.get(index).copied().unwrap_or(1.0)
    }

    /// Skew of channel `index`, samples.
    #[must_use]
    pub fn skew(&self, index: usize) -> f64 {
        self.skew_samples.get(index).copied().unwrap_or(0.0)
    }
}

fn in_range(
    key: &'static str,
    value: f64,
    range: RangeInclusive<f64>,
) -> Result<(), ScenarioError> {
    if range.contains(&value) {
        return Ok(());
    }
    Err(ScenarioError::OutOfRange {
        key,
        value,
        low: *range.start(),
        high: *range.end(),
    })
}

fn explain(text: &str, error: &toml::de::Error) -> ScenarioError {
    let start = error.span().map_or(0, |span| span.start).min(text.len());
    let line = text[..start].matches('\n').count() + 1;
    let mut quoted = error.message().split('`').skip(1).step_by(2);
    if error.message().starts_with("unknown field")
        && let Some(key) = quoted.next()
    {
        let nearest = quoted
            .map(|known| (strsim::jaro_winkler(key, known), known))
            .max_by(|a, b| a.0.total_cmp(&b.0))
            .filter(|(likeness, _)| *likeness > 0.6)
            .map(|(_, known)| known.to_owned());
        return ScenarioError::UnknownKey {
            key: key.to_owned(),
            line,
            nearest,
        };
    }
    ScenarioError::Syntax {
        message: error.message().to_owned(),
        line,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_empty_file_is_the_nominal_bench() {
        assert_eq!(Scenario::parse("").unwrap(), Scenario::default());
    }

    #[test]
    fn an_unknown_key_is_named_with_its_line_and_the_nearest_known_key() {
        let text = "[plate]\nresonance_hz = 35000.0\nmodal_mas_kg = 0.008\n";
        assert_eq!(
            Scenario::parse(text).unwrap_err(),
            ScenarioError::UnknownKey {
                key: "modal_mas_kg".into(),
                line: 3,
                nearest: Some("modal_mass_kg".into()),
            }
        );
    }

    #[test]
    fn an_unknown_table_and_a_wrong_type_are_named() {
        let unknown = Scenario::parse("[platte]\n").unwrap_err();
        assert!(
            matches!(unknown, ScenarioError::UnknownKey { key, line: 1, nearest: Some(n) } if key == "platte" && n == "plate")
        );
        let wrong = Scenario::parse("\n[plate]\nresonance_hz = \"high\"\n").unwrap_err();
        assert!(
            matches!(wrong, ScenarioError::Syntax { line: 3, .. }),
            "{wrong}"
        );
    }

    #[test]
    fn out_of_range_names_key_value_and_range() {
        let e = Scenario::parse("[participant]\nmu0 = 8.0\n").unwrap_err();
        assert_eq!(e.to_string(), "`participant.mu0` = 8 is outside 0.05 to 3");
        let nan = Scenario::parse("[film]\nlag_s = nan\n").unwrap_err();
        assert!(matches!(
            nan,
            ScenarioError::OutOfRange {
                key: "film.lag_s",
                ..
            }
        ));
    }

    #[test]
    fn a_sound_layer_is_held_to_what_there_is() {
        let sound = "[converter]\ngains = [1.0, -2.0]\n[sound_layer]\nrate_hz = 48000.0\nanti_alias = false\ninputs = [1, 0]\nslip = { channel = 1, samples = 2, after_s = 3.0 }\n";
        let layer = Scenario::parse(sound).unwrap().sound_layer;
        assert_eq!((layer.rate_hz, layer.inputs), (Some(48e3), vec![1, 0]));
        for (text, key) in [
            ("[converter]\ngains = [1.0, 200.0]\n", "converter.gains"),
            ("[converter]\ngains = [1, 1, 1, 1, 1]\n", "(entries)"),
            ("[sound_layer]\nrate_hz = 1000.0\n", "sound_layer.rate_hz"),
            ("[sound_layer]\ninputs = [4]\n", "sound_layer.inputs"),
            ("[sound_layer]\ninputs = [0, 1, 2, 3, 3]\n", "(entries)"),
            (
                "[sound_layer]\nslip = { channel = 9, samples = 1, after_s = 1.0 }\n",
                "sound_layer.slip.channel",
            ),
            (
                "[sound_layer]\nslip = { channel = 1, samples = 0, after_s = 1.0 }\n",
                "sound_layer.slip.samples",
            ),
            (
                "[sound_layer]\nslip = { channel = 1, samples = 1, after_s = -1.0 }\n",
                "sound_layer.slip.after_s",
            ),
            ("[sound_layer]\nrate = 48000.0\n", "rate_hz"),
        ] {
            let said = Scenario::parse(text).unwrap_err().to_string();
            assert!(said.contains(key), "{said}");
        }
    }

    #[test]
    fn force_sensor_and_masses_have_ranges() {
        for (table, key, good, bad) in [
            ("force_sensor", "normal_gain", "-1.3", "11.0"),
            ("force_sensor", "lateral_gain", "0.5", "-11.0"),
            ("force_sensor", "normal_drift_n_per_min", "0.1", "11.0"),
            ("force_sensor", "lateral_drift_n_per_min", "-0.1", "-11.0"),
            ("force_sensor", "wander_n", "0.01", "-0.01"),
            ("force_sensor", "wander_time_s", "5.0", "0.0"),
            ("force_sensor", "creep", "0.01", "0.3"),
            ("force_sensor", "creep_time_s", "5.0", "0.0"),
            ("masses", "gravity_m_per_s2", "9.81", "9.9"),
            ("masses", "error", "0.001", "-0.001"),
            ("masses", "tilt_rad", "-0.02", "0.3"),
            ("masses", "pulley_friction", "0.01", "0.6"),
            ("masses", "bounce_hz", "20.0", "0.1"),
            ("masses", "bounce_time_s", "0.3", "0.001"),
            ("masses", "swing_hz", "1.0", "0.1"),
            ("masses", "swing_time_s", "1.0", "0.001"),
            ("jitter", "force_gain", "0.1", "1.0"),
            ("jitter", "force_crosstalk", "0.1", "0.5"),
            ("jitter", "force_offset_n", "0.3", "6.0"),
            ("jitter", "force_drift_n_per_min", "0.3", "2.0"),
            ("jitter", "pulley_friction", "0.1", "0.5"),
        ] {
            let of = |value: &str| Scenario::parse(&format!("[{table}]\n{key} = {value}\n"));
            assert!(of(good).is_ok(), "{key}");
            let refused = of(bad).unwrap_err().to_string();
            assert!(refused.contains(&format!("{table}.{key}")), "{refused}");
        }
    }

    #[test]
    fn a_scenario_survives_writing_and_reading() {
        let scenario = Scenario {
            sound_layer: SoundLayer {
                rate_hz: Some(44_100.0),
                slip: Some(Slip {
                    channel: 1,
                    samples: 1,
                    after_s: 2.0,
                }),
                ..SoundLayer::default()
            },
            participant: ParticipantScenario {
                mu0: Some(0.9),
                z_t_n_s_per_m: Some([0.4, 3.0]),
                ..ParticipantScenario::default()
            },
            ..Scenario::default()
        };
        let text = toml::to_string(&scenario).unwrap();
        assert_eq!(Scenario::parse(&text).unwrap(), scenario);
    }

    #[test]
    fn jitter_is_off_by_default_deterministic_and_within_its_limits() {
        let nominal = Scenario::default();
        assert_eq!(nominal.realised(7), nominal);
        let mut on = nominal.clone();
        on.jitter.enabled = true;
        assert_eq!(on.realised(7), on.realised(7));
        assert_ne!(on.realised(7), on.realised(8));
        assert_eq!(on.realised(7).realised(7), on.realised(7));
        for seed in 0..200 {
            let r = on.realised(seed);
            let q = r.plate.omega_rad_per_s() * r.plate.modal_mass_kg / r.plate.damping_n_s_per_m;
            assert!((150.0..=350.0).contains(&q));
            assert!((r.plate.resonance_hz - 35e3).abs() <= 300.0);
            assert!((r.pickup.metres_per_unit / 5.0e-6 - 1.0).abs() <= 0.2);
            assert!((r.pickup.phase_rad - 0.2).abs() <= 0.5);
            assert!((r.plate.force_factor_n_per_v / 0.13 - 1.0).abs() <= 0.2);
            assert!(
                r.converter
                    .skew_samples
                    .iter()
                    .all(|s| (0.0..=1.0).contains(s))
            );
            let force = &r.force_sensor;
            for gain in [force.normal_gain, force.lateral_gain] {
                assert!((gain - 1.0).abs() <= 0.2);
            }
            for crosstalk in [force.lateral_to_normal, force.normal_to_lateral] {
                assert!(crosstalk.abs() <= 0.05);
            }
            for offset_n in [force.normal_offset_n, force.lateral_offset_n] {
                assert!(offset_n.abs() <= 0.03);
            }
            for drift in [force.normal_drift_n_per_min, force.lateral_drift_n_per_min] {
                assert!(drift.abs() <= 0.005);
            }
            assert!((0.0..=0.003).contains(&r.masses.pulley_friction));
        }
    }
}
