//! Range of every number in a scenario file: both ends are accepted, values beyond them are rejected.
#![expect(clippy::unwrap_used, reason = "a failing test should panic")]

use mock_world::person::FingerState;
use mock_world::plant::Plant;
use mock_world::scenario::{Scenario, ScenarioError};

/// Dotted path of a range from which a constant is drawn, and the least and greatest number accepted at either end.
const DRAW_RANGES: &[(&str, f64, f64)] = &[
    ("participant.spread.contact_area_m2", 10e-6, 1e-3),
    ("participant.spread.area_force_exponent", 0.0, 0.7),
    ("participant.spread.q0_rad_per_m", 1e3, 1e6),
    ("participant.spread.youngs_modulus_pa", 1e5, 1e9),
    ("participant.spread.loss_factor", 0.0, 1.0),
    ("participant.spread.lag_s", 2e-4, 0.1),
    ("participant.spread.lag_gap_exponent", -1.0, 1.0),
    ("participant.spread.floor", 0.0, 0.9),
    ("participant.spread.speed_exponent", -0.5, 0.5),
    ("participant.spread.ageing", -0.5, 5.0),
    ("participant.spread.ageing_time_s", 0.1, 1e3),
    ("participant.spread.growth", -0.5, 1.0),
    ("session.room_hz_per_min", -60.0, 60.0),
    ("session.room_damping_per_min", -0.05, 0.05),
    ("session.warmth_hz", -100.0, 100.0),
    ("session.warmth_damping", -0.5, 1.0),
    ("session.warmth_time_s", 0.1, 1e4),
    ("session.warmth_spread", 0.0, 1.0),
    ("session.damping_time_ratio", 0.1, 10.0),
    ("session.end_drop", -0.5, 0.5),
    ("session.end_tilt", -0.3, 0.3),
    ("session.second_mode_off_hz", 300.0, 1e4),
    ("session.second_mode_mass_kg", 1e-3, 1.0),
    ("session.second_mode_half_waves", 0.0, 10.0),
    ("session.lateral_resonance_hz", 100.0, 20e3),
    ("session.lateral_lag_s", 0.0, 0.02),
];

/// Dotted path of a key, and the least and greatest number accepted.
const RANGES: &[(&str, f64, f64)] = &[
    ("plate.resonance_hz", 20e3, 45e3),
    ("plate.modal_mass_kg", 1e-4, 1.0),
    ("plate.damping_n_s_per_m", 0.01, 1e3),
    ("plate.force_factor_n_per_v", 1e-4, 10.0),
    ("plate.end_drop", -0.5, 0.5),
    ("plate.end_tilt", -0.3, 0.3),
    ("plate.length_m", 0.01, 1.0),
    ("plate.across.wavelength_m", 5e-3, 1.0),
    ("plate.across.crest_m", -0.02, 0.02),
    ("plate.across.edge_share", 0.0, 0.2),
    ("plate.second_mode.resonance_hz", 5e3, 80e3),
    ("plate.second_mode.modal_mass_kg", 1e-4, 1.0),
    ("plate.second_mode.quality", 1.0, 1e4),
    ("plate.second_mode.actuator_ratio", -2.0, 2.0),
    ("plate.second_mode.pickup_ratio", -2.0, 2.0),
    ("plate.second_mode.contact_ratio", -2.0, 2.0),
    ("plate.second_mode.half_waves", 0.0, 10.0),
    ("plate.drift.room_hz_per_min", -60.0, 60.0),
    ("plate.drift.room_damping_per_min", -0.05, 0.05),
    ("plate.drift.room_period_s", 10.0, 7.2e3),
    ("plate.drift.warmth_hz", -100.0, 100.0),
    ("plate.drift.warmth_damping", -0.5, 1.0),
    ("plate.drift.warmth_time_s", 0.1, 1e4),
    ("plate.drift.warmth_spread", 0.0, 1.0),
    ("plate.drift.damping_time_ratio", 0.1, 10.0),
    ("plate.drift.amplitude_hz_per_um2", -5.0, 5.0),
    ("amplifier.volts_per_unit", 0.1, 1e3),
    ("amplifier.bandwidth_hz", 40e3, 10e6),
    ("amplifier.one_shot_s", 1e-3, 10.0),
    ("pickup.metres_per_unit", 1e-9, 1e-3),
    ("pickup.phase_rad", -3.15, 3.15),
    ("converter.readback_volts_per_unit", 0.1, 1e4),
    ("converter.clip_units", 1e-3, 1.0),
    ("converter.noise_units_per_sqrt_hz", 0.0, 1e-3),
    ("converter.offset_units", -1.0, 1.0),
    ("converter.crosstalk", -1.0, 1.0),
    ("converter.clock_ppm", -1e3, 1e3),
    ("film.ambient_pressure_pa", 1e3, 1e6),
    ("film.contact_area_m2", 10e-6, 1e-3),
    ("film.area_force_exponent", 0.0, 0.7),
    ("film.contact_width.width_m", 1e-4, 0.03),
    ("film.contact_width.squareness", 1.0, 20.0),
    ("film.q0_rad_per_m", 1e3, 1e6),
    ("film.youngs_modulus_pa", 1e5, 1e9),
    ("film.poisson_ratio", 0.0, 0.5),
    ("film.loss_factor", 0.0, 1.0),
    ("film.lag_s", 2e-4, 0.1),
    ("film.lag_gap_exponent", -1.0, 1.0),
    ("film.presliding_m", 1e-5, 5e-3),
    ("friction.floor", 0.0, 0.9),
    ("friction.speed_exponent", -0.5, 0.5),
    ("friction.ageing", -0.5, 5.0),
    ("friction.ageing_time_s", 0.1, 1e3),
    ("friction.load_exponent", -0.5, 0.5),
    ("friction.viscous_n_s_per_m", 0.0, 20.0),
    ("laws.asperity_cutoff", 2.5, 6.0),
    ("laws.adhesion_n", 0.0, 1.0),
    ("laws.adhesion_range_m", 0.5e-6, 20e-6),
    ("laws.leak_gap_m", 2e-6, 1e-3),
    ("laws.tissue_force_exponent", -1.0, 1.0),
    ("laws.loss_exponent", -1.0, 1.0),
    ("force_sensor.rate_hz", 500.0, 20e3),
    ("force_sensor.noise_n", 0.0, 1.0),
    ("force_sensor.resonance_hz", 100.0, 20e3),
    ("force_sensor.damping_ratio", 0.05, 2.0),
    ("force_sensor.lateral_resonance_hz", 100.0, 20e3),
    ("force_sensor.lateral_lag_s", 0.0, 0.02),
    ("force_sensor.range_n", 0.1, 1e3),
    ("force_sensor.normal_gain", -10.0, 10.0),
    ("force_sensor.lateral_gain", -10.0, 10.0),
    ("force_sensor.normal_offset_n", -10.0, 10.0),
    ("force_sensor.lateral_offset_n", -10.0, 10.0),
    ("force_sensor.normal_drift_n_per_min", -10.0, 10.0),
    ("force_sensor.lateral_drift_n_per_min", -10.0, 10.0),
    ("force_sensor.wander_n", 0.0, 1.0),
    ("force_sensor.wander_time_s", 0.1, 1e4),
    ("force_sensor.creep", 0.0, 0.2),
    ("force_sensor.creep_time_s", 0.1, 1e4),
    ("force_sensor.lateral_to_normal", -0.5, 0.5),
    ("force_sensor.normal_to_lateral", -0.5, 0.5),
    ("force_sensor.clock_ppm", -1e4, 1e4),
    ("force_sensor.burst_period_s", 1e-4, 0.1),
    ("force_sensor.gauges.delay_s", 1.5e-4, 0.05),
    ("force_sensor.gauges.noise_v", 0.0, 1.0),
    ("force_sensor.gauges.offset_v", -1.0, 1.0),
    ("force_sensor.gauges.ac_hz", 1e-3, 100.0),
    ("masses.gravity_m_per_s2", 9.76, 9.84),
    ("masses.error", 0.0, 0.1),
    ("masses.tilt_rad", -0.2, 0.2),
    ("masses.pulley_friction", 0.0, 0.5),
    ("masses.bounce_hz", 0.5, 100.0),
    ("masses.bounce_time_s", 0.01, 100.0),
    ("masses.swing_hz", 0.5, 100.0),
    ("masses.swing_time_s", 0.01, 100.0),
    ("reference.per_volt", 1e-9, 10.0),
    ("reference.volts_per_unit", 1e-3, 1e3),
    ("reference.delay_s", 0.0, 3e-5),
    ("reference.noise_v", 0.0, 1.0),
    ("meter.error", 0.0, 0.1),
    ("meter.noise_v", 0.0, 1.0),
    ("sound_layer.delay_s", 0.0, 0.2),
    ("sound_layer.delay_spread_s", 0.0, 0.2),
    ("encoder.counts_per_m", 1e3, 1e7),
    ("participant.moisture.relative_sd", 0.0, 0.2),
    ("participant.moisture.time_s", 0.1, 1e4),
    ("participant.moisture.growth", -0.5, 1.0),
    ("participant.moisture.growth_time_s", 0.1, 1e4),
    ("participant.behaviour.force_aim_n", 0.05, 5.0),
    ("participant.behaviour.force_misjudgement", 0.0, 1.0),
    ("participant.behaviour.force_learning", 0.0, 1.0),
    ("participant.behaviour.force_drift_n", 0.0, 1.0),
    ("participant.behaviour.force_drift_time_s", 0.01, 1e3),
    ("participant.behaviour.tremor_n", 0.0, 1.0),
    ("participant.behaviour.tremor_m", 0.0, 1e-3),
    ("participant.behaviour.reaction_s", 0.05, 2.0),
    ("participant.behaviour.speed_error", 0.0, 0.5),
    ("participant.behaviour.speed_wander", 0.0, 0.5),
    ("participant.behaviour.tracking_hz", 0.2, 10.0),
    ("participant.behaviour.late_start_probability", 0.0, 1.0),
    ("participant.behaviour.late_start_s", 0.0, 10.0),
    ("participant.behaviour.lift_off_probability", 0.0, 1.0),
    ("participant.behaviour.lift_off_s", 0.0, 10.0),
    ("jitter.pickup_sensitivity", 0.0, 0.9),
    ("jitter.pickup_phase_rad", 0.0, 3.15),
    ("jitter.resonance_hz", 0.0, 3e3),
    ("jitter.force_factor", 0.0, 0.9),
    ("jitter.skew_samples", 0.0, 4.0),
    ("jitter.force_gain", 0.0, 0.9),
    ("jitter.force_crosstalk", 0.0, 0.3),
    ("jitter.force_offset_n", 0.0, 5.0),
    ("jitter.force_drift_n_per_min", 0.0, 1.0),
    ("jitter.pulley_friction", 0.0, 0.3),
    ("participant.sigma_t_m", 0.3e-6, 6e-6),
    ("participant.mu0", 0.05, 3.0),
    ("participant.population.spearman_mu0_im_z_t", -1.0, 1.0),
];

fn parse(path: &str, value: &str) -> Result<Scenario, ScenarioError> {
    let (table, key) = path.rsplit_once('.').unwrap();
    Scenario::parse(&format!("[{table}]\n{key} = {value}\n"), "test.toml")
}

/// Requires that `value` is rejected for the key `path`, on its line and with both limits.
fn require_rejection(path: &str, value: &str, limits: (f64, f64)) {
    match parse(path, value) {
        Err(ScenarioError::OutOfRange { line, range, .. }) => {
            assert_eq!((line, range.key.as_str()), (Some(2), path));
            assert_eq!((range.low, range.high), limits, "{path}");
        }
        result => panic!("{path} = {value}: {result:?}"),
    }
}

/// Returns the dotted paths of all numbers in a table.
fn numbers(table: &toml::Table, path: &str) -> Vec<String> {
    let path_of = |key: &str| format!("{path}{key}");
    table
        .iter()
        .flat_map(|(key, value)| match value {
            toml::Value::Table(inner) => numbers(inner, &format!("{}.", path_of(key))),
            toml::Value::Float(_) => vec![path_of(key)],
            _ => Vec::new(),
        })
        .collect()
}

#[test]
fn no_number_is_without_a_range() {
    let table = toml::Table::try_from(Scenario::default()).unwrap();
    let numbers = numbers(&table, "");
    assert!(numbers.len() > 70, "{}", numbers.len());
    for path in numbers {
        assert!(RANGES.iter().any(|(key, ..)| *key == path), "{path}");
    }
}

#[test]
fn both_ends_of_a_range_are_accepted_and_values_beyond_are_not() {
    for &(path, low, high) in RANGES {
        let margin = 1e-3 * (high - low);
        for end in [low, high] {
            assert!(parse(path, &format!("{end:?}")).is_ok(), "{path} = {end}");
        }
        for value in [low - margin, high + margin] {
            require_rejection(path, &format!("{value:?}"), (low, high));
        }
    }
}

#[test]
fn counts_have_ranges_too() {
    for (path, low, high) in [("converter.channels", 2, 32), ("converter.bits", 8, 32)] {
        for end in [low, high] {
            assert!(parse(path, &end.to_string()).is_ok(), "{path} = {end}");
        }
        for value in [low - 1, high + 1] {
            require_rejection(path, &value.to_string(), (f64::from(low), f64::from(high)));
        }
    }
}

#[test]
fn a_standard_deviation_of_the_population_is_at_most_its_mean() {
    for (key, mean, low, high) in [
        ("sigma_t_m", 1.7e-6, 0.5e-6, 4e-6),
        ("re_z_t_n_s_per_m", 0.5, 0.1, 50.0),
        ("im_z_t_n_s_per_m", 3.0, 1.0, 50.0),
        ("mu0", 0.8, 0.3, 1.5),
    ] {
        let path = format!("participant.population.{key}");
        assert!(parse(&path, &format!("[{mean:?}, {mean:?}]")).is_ok());
        require_rejection(
            &path,
            &format!("[{mean:?}, {:?}]", 1.01 * mean),
            (0.0, mean),
        );
        require_rejection(&path, &format!("[{:?}, 0.0]", 0.99 * low), (low, high));
        require_rejection(&path, &format!("[{:?}, 0.0]", 1.01 * high), (low, high));
    }
}

#[test]
fn the_quality_factors_of_the_jitter_ascend() {
    assert!(parse("jitter.quality", "[10.0, 1e4]").is_ok());
    require_rejection("jitter.quality", "[300.0, 200.0]", (10.0, 200.0));
    require_rejection("jitter.quality", "[9.0, 200.0]", (10.0, 200.0));
    require_rejection("jitter.quality", "[20.0, 1.1e4]", (20.0, 1e4));
}

#[test]
fn a_draw_range_lies_within_the_range_of_its_constant_and_ascends() {
    for &(path, low, high) in DRAW_RANGES {
        let middle = 0.5 * (low + high);
        for range in [[low, high], [middle, middle]] {
            assert!(
                parse(path, &format!("{range:?}")).is_ok(),
                "{path} = {range:?}"
            );
        }
        require_rejection(path, &format!("[{middle:?}, {low:?}]"), (middle, high));
        require_rejection(path, &format!("[{:?}, {high:?}]", low - 0.1), (low, high));
        require_rejection(path, &format!("[{low:?}, {:?}]", 1.1 * high), (low, high));
        assert!(parse(path, "[nan, 1.0]").is_err(), "{path}");
    }
}

#[test]
fn every_draw_range_is_in_the_table() {
    let text =
        toml::to_string(&mock_world::scenario::built_in("population-unkind").unwrap()).unwrap();
    let table: toml::Table = toml::from_str(&text).unwrap();
    let table_at = |path: &str| {
        path.split('.')
            .fold(toml::Value::Table(table.clone()), |value, key| {
                value[key].clone()
            })
    };
    for table in ["participant.spread", "session"] {
        for key in table_at(table).as_table().unwrap().keys() {
            let path = format!("{table}.{key}");
            assert!(DRAW_RANGES.iter().any(|(key, ..)| *key == path), "{path}");
        }
    }
}

/// Requires finite results for a finger that lands on a driven plate, presses with up to 3 N, slides and lifts.
fn requires_finite(scenario: &Scenario, case: &str) {
    let mut plant = Plant::new(scenario, 1, 96e3);
    let mut inputs = vec![0.0; 96 * plant.channels()];
    for ms in 0..40 {
        let drive: Vec<f32> = (0..96)
            .map(|i| {
                let t = f64::from(ms * 96 + i) / 96e3;
                let envelope = 0.4 * (1.0 - 0.95 * (50.0 * std::f64::consts::TAU * t).cos());
                (envelope * (std::f64::consts::TAU * 35e3 * t).sin()) as f32
            })
            .collect();
        let touching = (5..35).contains(&ms);
        let finger = FingerState {
            position_m: 0.05,
            velocity_m_per_s: if ms < 20 { 0.05 } else { -0.05 },
            normal_n: if touching {
                0.1 * f64::from(ms - 4)
            } else {
                0.0
            },
            touching,
        };
        plant.step(&drive, true, &finger, &mut inputs);
        assert!(inputs.iter().all(|v| v.is_finite()), "{case}");
        assert!(
            plant.forces().iter().all(|f| f.lateral_n.is_finite()),
            "{case}"
        );
        for truth in plant.truth() {
            // Far above any realistic amplitude, far below that of an unstable plate.
            assert!(truth.amplitude_m < 1e-2, "{case}: {truth:?}");
            let is_pressed = truth.normal_n > 0.0;
            let finite = truth.gap_m.is_finite() && truth.mu.is_finite() && truth.lag_s.is_finite();
            assert!(!is_pressed || finite, "{case}: {truth:?}");
        }
    }
}

#[test]
fn the_plant_stays_finite_at_both_ends_of_every_range() {
    for &(path, low, high) in RANGES {
        for end in [low, high] {
            let scenario = parse(path, &format!("{end:?}")).unwrap();
            requires_finite(&scenario, &format!("{path} = {end}"));
        }
    }
    for &(path, low, high) in DRAW_RANGES {
        for end in [low, high] {
            let scenario = parse(path, &format!("[{end:?}, {end:?}]")).unwrap();
            requires_finite(&scenario, &format!("{path} = {end}"));
        }
    }
}

#[test]
fn the_plant_stays_finite_with_everything_at_its_worst_at_once() {
    for text in [
        "[film]\ncontact_area_m2 = 10e-6\nq0_rad_per_m = 1e3\nyoungs_modulus_pa = 1e5\narea_force_exponent = 0.7\n",
        "[laws]\nasperity_cutoff = 2.5\nadhesion_n = 1.0\nadhesion_range_m = 20e-6\nleak_gap_m = 2e-6\n\
         tissue_force_exponent = 1.0\nloss_exponent = -1.0\n",
        "[laws]\nasperity_cutoff = 2.5\nadhesion_n = 1.0\nadhesion_range_m = 0.5e-6\nleak_gap_m = 2e-6\n\
         tissue_force_exponent = -1.0\nloss_exponent = 1.0\n[film]\nlag_s = 2e-4\nlag_gap_exponent = 1.0\n",
        "[plate]\nend_drop = 0.5\nend_tilt = -0.3\n[plate.drift]\nroom_hz_per_min = 60.0\nwarmth_hz = -100.0\n\
         warmth_damping = -0.5\nwarmth_time_s = 0.1\namplitude_hz_per_um2 = -5.0\n\
         [plate.second_mode]\nresonance_hz = 35300.0\nquality = 1e4\nhalf_waves = 10.0\n",
        "[plate.across]\nwavelength_m = 5e-3\ncrest_m = 0.02\nedge_share = 0.2\n[film]\narea_force_exponent = 0.7\n\
         [film.contact_width]\nwidth_m = 0.03\nsquareness = 1.0\n",
        "[friction]\nfloor = 0.9\nspeed_exponent = -0.5\nageing = 5.0\nageing_time_s = 0.1\nload_exponent = -0.5\n\
         viscous_n_s_per_m = 20.0\n[participant.moisture]\nrelative_sd = 0.2\ngrowth = 1.0\ngrowth_time_s = 0.1\n",
    ] {
        requires_finite(&Scenario::parse(text, "test.toml").unwrap(), text);
    }
}
