//! Guessed maps of files as other laboratories write them: units, rates, scales and names that only the file's own
//! conventions tell.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

mod files;

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;

use files::{
    FINGER, Finger, Matlab, Property, Tdms, TdmsValues, electrical, envelope, guessed, is_checked,
    line, noise, samples,
};
use import_look::look;
use import_map::{Electrical, Rate, TimeBase, Travel};

#[test]
fn times_without_a_unit_have_the_one_in_which_the_carrier_is_a_plates() {
    // A card's own counter in µs or ms, under names that say nothing; the force's record begins later.
    for (scale, start) in [(1e6, 4e6), (1e3, 900.0)] {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("S4_T2.mat");
        let (fast, slow) = (160e3, 4e3);
        let mut file = Matlab::default();
        let signals = samples(fast, |n, _| electrical(n, fast, 42e3));
        file.add("q1", &samples(fast, |_, t| start + scale * t));
        file.add(
            "q2",
            &signals.iter().map(|[drive, _]| *drive).collect::<Vec<_>>(),
        );
        file.add(
            "q3",
            &signals
                .iter()
                .map(|[_, pickup]| 1e6 * pickup)
                .collect::<Vec<_>>(),
        );
        let forces = samples(slow, |n, t| (t, FINGER.forces_n(n, t)));
        let late: Vec<_> = forces.into_iter().filter(|(t, _)| *t > 0.15).collect();
        file.add(
            "q4",
            &late
                .iter()
                .map(|(t, _)| start + scale * t)
                .collect::<Vec<_>>(),
        );
        file.add(
            "Fn",
            &late
                .iter()
                .map(|(_, [normal, _])| *normal)
                .collect::<Vec<_>>(),
        );
        file.add(
            "Ft",
            &late
                .iter()
                .map(|(_, [_, lateral])| *lateral)
                .collect::<Vec<_>>(),
        );
        file.add("q5", &samples(500.0, |_, t| start + scale * t));
        file.add("pos_mm", &samples(500.0, |_, t| 1e3 * FINGER.position_m(t)));
        std::fs::write(&path, file.0).unwrap();

        let (text, map) = guessed(&[path]);
        let Electrical::Signals { drive, .. } = &map.electrical else {
            panic!("{text}")
        };
        let unit = |time: &TimeBase, expected: &str| {
            let TimeBase::Column {
                name,
                seconds_per_unit,
            } = time
            else {
                panic!("{text}")
            };
            assert_eq!(name, expected, "{text}");
            let unit_s = seconds_per_unit.unwrap_or(1.0);
            assert!((unit_s * scale - 1.0).abs() < 1e-9, "{text}");
        };
        unit(&drive.time, "q1");
        unit(&map.normal.as_ref().unwrap().time, "q4");
        assert!(text.contains("carrier 42 000 Hz"), "{text}");
        let reason = line(&text, "drive", "seconds_per_unit");
        assert!(
            reason.contains("the carrier of `q2` is at 42 000 Hz") && !is_checked(reason),
            "{reason}"
        );
        // One clock counted both.
        let clock = line(&text, "normal", "clock");
        assert!(clock.contains("\"same\"") && !is_checked(clock), "{clock}");
        assert!(text.contains("later than that of `q2`"), "{text}");
    }
}

#[test]
fn times_of_forces_alone_have_the_unit_in_which_a_finger_moves_or_are_doubted() {
    let folder = tempfile::tempdir().unwrap();
    // 25 kHz in ms for 3.2 s would last 53 min at 25 Hz in s.
    let table = |name: &str, is_moving: bool| {
        let path = folder.path().join(name);
        let mut text = "tick;Fn;Ft;x\n".to_owned();
        for (n, [normal, lateral]) in samples(25e3, |n, t| FINGER.forces_n(n, t))
            .iter()
            .enumerate()
        {
            let t = n as f64 / 25e3;
            let values = match is_moving {
                true => [*normal, *lateral, FINGER.position_m(t)],
                false => [noise(n), noise(n + 1), noise(n + 2)],
            };
            writeln!(
                text,
                "{:.2};{:.5};{:.5};{:.6}",
                1e3 * t,
                values[0],
                values[1],
                values[2]
            )
            .unwrap();
        }
        std::fs::write(&path, text).unwrap();
        path
    };
    let (text, _) = guessed(&[table("P1_T1.csv", true)]);
    let unit = line(&text, "normal", "seconds_per_unit");
    assert!(
        unit.starts_with("seconds_per_unit = 0.001") && !is_checked(unit),
        "{text}"
    );
    std::fs::remove_file(folder.path().join("map.toml")).unwrap();
    let (text, _) = guessed(&[table("P1_T2.csv", false)]);
    assert!(
        is_checked(line(&text, "normal", "seconds_per_unit")),
        "{text}"
    );
}

#[test]
fn a_guess_without_drive_and_pickup_names_the_fast_arrays_at_its_top() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("S2_T1.mat");
    let mut file = Matlab::default();
    file.add("e1", &samples(50e3, |n, _| noise(n)));
    file.add("e2", &samples(50e3, |n, _| noise(n + 11)));
    file.add("fs", &[50e3]);
    file.add("Fn", &samples(1e3, |n, t| FINGER.forces_n(n, t)[0]));
    file.add("Ft", &samples(1e3, |n, t| FINGER.forces_n(n, t)[1]));
    file.add("fs_force", &[1e3]);
    std::fs::write(&path, file.0).unwrap();
    let (text, _) = guessed(&[path]);
    let top = text.split("format = 1").next().unwrap();
    assert!(
        top.contains("# CHECK: drive and pickup are left out: none of `e1`, `e2`"),
        "{text}"
    );
}

fn force_table(path: &Path, header: &str, scale: f64) {
    let mut text = format!("{header}\n");
    for (n, [normal, lateral]) in samples(1e3, |n, t| FINGER.forces_n(n, t))
        .iter()
        .enumerate()
    {
        let t = n as f64 * 1e-3;
        let row = format!(
            "{t:.3};{:.4};{:.4};{:.4}",
            scale * normal,
            scale * lateral,
            1e3 * FINGER.position_m(t)
        );
        writeln!(text, "{row}").unwrap();
    }
    std::fs::write(path, text).unwrap();
}

#[test]
fn files_with_the_numbers_of_one_trial_are_its_parts_and_stated_units_are_used() {
    let folder = tempfile::tempdir().unwrap();
    let mut files = Vec::new();
    for trial in [4, 5] {
        let path = folder.path().join(format!("Osci_VP11_{trial:02}.csv"));
        let mut text = "s;A;B\n".to_owned();
        for (n, [drive, pickup]) in samples(100e3, |n, _| electrical(n, 100e3, 31e3))
            .iter()
            .enumerate()
        {
            writeln!(
                text,
                "{:.5};{drive:.3};{:.5}",
                n as f64 * 1e-5,
                1e6 * pickup
            )
            .unwrap();
        }
        std::fs::write(&path, text).unwrap();
        files.push(path);
        let path = folder.path().join(format!("Zelle_VP11_{trial:02}.csv"));
        force_table(&path, "t [s];Fz [dN];Fx [dN];Weg [mm]", 10.0);
        files.push(path);
    }
    let (text, map) = guessed(&files);
    assert!(
        text.contains(r"files = 'Osci_VP(?<participant>\d+)_(?<trial>\d+)\.csv'"),
        "{text}"
    );
    let normal = map.normal.unwrap();
    assert_eq!(
        normal.source.file.unwrap().as_str(),
        "Zelle_VP{participant}_{trial}.csv",
        "{text}"
    );
    assert!((normal.newtons_per_unit - 0.1).abs() < 1e-12, "{text}");
    assert!(
        !is_checked(line(&text, "normal", "newtons_per_unit")),
        "{text}"
    );
}

#[test]
fn magnitudes_and_phases_of_a_lock_in_are_envelopes_in_degrees_or_radians() {
    let wrapped = |angle: f64, turn: f64| (angle / turn - (angle / turn).round()) * turn;
    for (header, turn, is_degrees) in [
        ("t;mag1;phase1;mag2;phase2;Fz_N;Fx_N", 360.0, true),
        ("t;amp_ldv;phi_ldv;amp_exc;phi_exc;Fz_N;Fx_N", TAU, false),
        ("t;|u| [V];arg(u);|w| [um];arg(w);Fz_N;Fx_N", TAU, false),
        (
            "t;ampDrive;angleDrive (deg);ampPickup;anglePickup (deg);Fz_N;Fx_N",
            360.0,
            true,
        ),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("vp2_t9.csv");
        let is_pickup_first = header.contains("ldv;");
        let mut text = format!("{header}\n");
        for (n, [normal, lateral]) in samples(5e3, |n, t| FINGER.forces_n(n, t))
            .iter()
            .enumerate()
        {
            let t = n as f64 / 5e3;
            let (drive, pickup) = (envelope(t), 0.4 * envelope(t - 1.2e-3));
            // The finger shifts the pickup's phase, across half a turn.
            let phase = turn
                * (0.48 + 0.05 * f64::from(u8::from(Finger::is_touching(t))) + 1e-3 * noise(n));
            let drive = format!(
                "{drive:.6};{:.6}",
                wrapped(turn * (0.1 + 1e-4 * noise(n)), turn)
            );
            let pickup = format!("{pickup:.6};{:.6}", wrapped(phase, turn));
            let [first, second] = match is_pickup_first {
                true => [pickup, drive],
                false => [drive, pickup],
            };
            writeln!(text, "{t};{first};{second};{normal:.5};{lateral:.5}").unwrap();
        }
        std::fs::write(&path, text).unwrap();
        let (text, map) = guessed(&[path]);
        assert!(
            matches!(map.electrical, Electrical::Envelopes { .. }),
            "{text}"
        );
        let columns: Vec<&str> = header.split(';').collect();
        let (drive, pickup) = if is_pickup_first { (3, 1) } else { (1, 3) };
        for (key, magnitude) in [("drive", drive), ("pickup", pickup)] {
            let phase = magnitude + 1;
            let unit = if is_degrees { "deg" } else { "rad" };
            let value = format!(
                "{key} = {{ amplitude = \"{}\", phase_{unit} = \"{}\" }}",
                columns[magnitude], columns[phase]
            );
            assert!(
                line(&text, "envelopes", key).starts_with(&value),
                "{value}\n{text}"
            );
        }
    }
}

fn integers(values: &[f64], count: f64) -> TdmsValues {
    TdmsValues::Integers(
        values
            .iter()
            .map(|value| (value / count).round() as i16)
            .collect(),
    )
}

#[test]
fn attributes_that_scale_are_applied_and_counts_of_a_unit_without_one_are_checked() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("P8_run3.tdms");
    let rate = 125e3;
    let signals = samples(rate, |n, _| electrical(n, rate, 28e3));
    let drive: Vec<f64> = signals.iter().map(|[drive, _]| *drive).collect();
    let pickup: Vec<f64> = signals.iter().map(|[_, pickup]| *pickup).collect();
    let normal = samples(2e3, |n, t| FINGER.forces_n(n, t)[0]);
    let lateral = samples(2e3, |n, t| FINGER.forces_n(n, t)[1]);
    let position = samples(200.0, |_, t| FINGER.position_m(t));
    let mut file = Tdms::default();
    let unit = |unit| Property::Text("unit_string", unit);
    file.add(
        "fast/monitor drive",
        &integers(&drive, 0.004),
        &[
            unit("V"),
            Property::Number("resolution", 0.004),
            Property::Number("Fs", rate),
        ],
    );
    file.add(
        "fast/ldv",
        &integers(&pickup, 5e-11),
        &[
            unit("um"),
            Property::Number("scale_factor", 5e-5),
            Property::Number("add_offset", 0.3),
        ],
    );
    file.add(
        "force/Fz",
        &integers(&normal, 1e-3),
        &[unit("N"), Property::Number("sampling_rate", 2e3)],
    );
    file.add(
        "force/Fx",
        &integers(&lateral, 1e-3),
        &[unit("N"), Property::Number("slope", 1e-3)],
    );
    // A card counts half milliseconds.
    file.add(
        "force/clock",
        &integers(&samples(2e3, |_, t| t), 5e-4),
        &[unit("ms"), Property::Number("scale", 0.5)],
    );
    file.add(
        "stage/counter",
        &integers(&position, 5e-6),
        &[
            Property::Number("counts_per_mm", 200.0),
            Property::Number("rate", 200.0),
        ],
    );
    file.write(&path);

    let (text, map) = guessed(std::slice::from_ref(&path));
    let volts = line(&text, "drive", "volts_per_unit");
    assert!(volts.starts_with("volts_per_unit = 0.004 "), "{text}");
    let metres = line(&text, "pickup", "metres_per_unit");
    assert!(
        metres.starts_with("metres_per_unit = 5e-11 ") && !is_checked(metres),
        "{text}"
    );
    assert!(
        metres.contains("scale_factor = 0.00005") || metres.contains("scale_factor = 5e-5"),
        "{metres}"
    );
    assert!(
        line(&text, "drive", "rate_hz").starts_with("rate_hz = \"/fast/monitor drive@Fs\""),
        "{text}"
    );
    let seconds = line(&text, "normal", "seconds_per_unit");
    assert!(
        seconds.starts_with("seconds_per_unit = 0.0005 ") && !is_checked(seconds),
        "{text}"
    );
    let counts = line(&text, "normal", "newtons_per_unit");
    assert!(
        is_checked(counts) && counts.contains("whole numbers"),
        "{text}"
    );
    let lateral = line(&text, "lateral", "newtons_per_unit");
    assert!(
        lateral.starts_with("newtons_per_unit = 0.001 ") && !is_checked(lateral),
        "{text}"
    );
    let position = map.position.unwrap();
    assert!(
        matches!(position.travel, Travel::Position { metres_per_unit, .. } if (metres_per_unit - 5e-6).abs() < 1e-12),
        "{text}"
    );
    assert!(
        matches!(position.time, TimeBase::Rate(Rate::Scalar(ref name)) if name == "/stage/counter@rate"),
        "{text}"
    );
}

#[test]
fn rates_of_an_array_precede_those_by_the_length() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("P8_run3.tdms");
    let rate = 125e3;
    let signals = samples(rate, |n, _| electrical(n, rate, 28e3));
    let forces = samples(1e3, |n, t| FINGER.forces_n(n, t));
    // The force's program stopped 4 % earlier: its length alone would state 960 Hz.
    let kept = &forces[..forces.len() * 96 / 100];
    let mut file = Tdms::default();
    let column = |index: usize| TdmsValues::Floats(signals.iter().map(|row| row[index]).collect());
    file.add("a/u", &column(0), &[Property::Number("Fs", rate)]);
    file.add("a/w", &column(1), &[Property::Number("Fs", rate)]);
    let column = |index: usize| TdmsValues::Floats(kept.iter().map(|row| row[index]).collect());
    file.add("b/Fn", &column(0), &[Property::Number("Fs", 1e3)]);
    file.add("b/Ft", &column(1), &[Property::Number("Fs", 1e3)]);
    let pixels = TdmsValues::Floats(samples(50.0, |_, t| 2e4 * FINGER.position_m(t)));
    file.add(
        "cam/x",
        &pixels,
        &[
            Property::Text("unit_string", "px"),
            Property::Number("fps", 50.0),
        ],
    );
    file.write(&path);
    let (text, _) = guessed(std::slice::from_ref(&path));
    let rate = line(&text, "normal", "rate_hz");
    assert!(
        rate.starts_with("rate_hz = \"/b/Fn@Fs\"") && !is_checked(rate),
        "{text}"
    );
    let pixel = line(&text, "position", "metres_per_unit");
    assert!(
        is_checked(pixel) && pixel.contains("px, which is no length"),
        "{text}"
    );
    // Without a length the speeds of the strokes are not known.
    assert!(
        is_checked(line(&text, "intervals", "exploration")),
        "{text}"
    );
}

/// The streams of the second trial look clearer than those of the first.
#[test]
fn a_map_of_a_file_with_several_trials_is_of_one_of_them() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("P8.tdms");
    let mut file = Tdms::default();
    for (trial, rate, scale) in [(1, 100e3, 0.2), (2, 96e3, 1.0)] {
        let signals = samples(rate, |n, _| electrical(n, rate, 28e3));
        let forces = samples(1e3, |n, t| FINGER.forces_n(n, t).map(|force| scale * force));
        let places = samples(1e3, |_, t| scale * FINGER.position_m(t));
        let mut add = |name: &str, values: Vec<f64>, rate: f64| {
            file.add(
                &format!("trial {trial}/{name}"),
                &TdmsValues::Floats(values),
                &[Property::Number("Fs", rate)],
            );
        };
        add("u", signals.iter().map(|row| row[0]).collect(), rate);
        add("w", signals.iter().map(|row| row[1]).collect(), rate);
        add("Fn", forces.iter().map(|row| row[0]).collect(), 1e3);
        add("Ft", forces.iter().map(|row| row[1]).collect(), 1e3);
        add("x", places, 1e3);
    }
    file.write(&path);
    let (text, _) = guessed(std::slice::from_ref(&path));
    for (table, array) in [
        ("drive", "trial 1/u"),
        ("pickup", "trial 1/w"),
        ("normal", "trial 1/Fn"),
        ("lateral", "trial 1/Ft"),
        ("position", "trial 1/x"),
    ] {
        assert!(
            line(&text, table, "from").contains(array),
            "{table}: {text}"
        );
    }
    assert!(
        line(&text, "drive", "rate_hz").contains("trial 1/u@Fs"),
        "{text}"
    );
    let place = line(&text, "place", "trial");
    assert!(
        is_checked(place) && place.contains("several recordings"),
        "{text}"
    );
}

#[test]
fn units_in_the_heading_of_labview_and_of_velocities_are_used() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("S3_T4.lvm");
    let mut text = "LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t.\nX_Columns\tOne\n***End_of_Header***\t\n\t\n\
                    Channels\t3\t\t\t\nTime\t09:30:01.5\t09:30:01.5\t09:30:01.5\t\nY_Unit_Label\tmN\tmN\tmm/s\t\n\
                    Delta_X\t0.001\t0.001\t0.001\t\n***End_of_Header***\t\t\t\t\nX_Value\tpress\tshear\tspeed\tComment\n"
        .to_owned();
    for (n, [normal, lateral]) in samples(1e3, |n, t| FINGER.forces_n(n, t))
        .iter()
        .enumerate()
    {
        let t = n as f64 * 1e-3;
        writeln!(
            text,
            "{t:.6}\t{:.3}\t{:.3}\t{:.4}\t",
            1e3 * normal,
            1e3 * lateral,
            1e3 * FINGER.velocity_m_s(t)
        )
        .unwrap();
    }
    std::fs::write(&path, text).unwrap();
    let (text, map) = guessed(std::slice::from_ref(&path));
    assert!(
        (map.normal.unwrap().newtons_per_unit - 1e-3).abs() < 1e-12,
        "{text}"
    );
    assert!(
        !is_checked(line(&text, "lateral", "newtons_per_unit")),
        "{text}"
    );
    assert!(
        line(&text, "velocity", "metres_per_unit").starts_with("metres_per_unit = 0.001 "),
        "{text}"
    );

    // A velocity by its name's end, and what only resembles statements.
    let table = folder.path().join("S3_T5.csv");
    force_table(&table, "time;Fn_mN;Ft_mN;slide_mm_s", 1e3);
    std::fs::remove_file(folder.path().join("map.toml")).unwrap();
    let (text, _) = guessed(std::slice::from_ref(&table));
    assert!(
        line(&text, "velocity", "from").contains("slide_mm_s"),
        "{text}"
    );
    let column = folder.path().join("one.txt");
    let pair = folder.path().join("pair.csv");
    let rows: String = (0..100).map(|n| format!("{:.3}\n", noise(n))).collect();
    std::fs::write(&column, rows).unwrap();
    let rows: String = (0..100)
        .map(|n| format!("{}.5,{:.3}\n", n, noise(n)))
        .collect();
    std::fs::write(&pair, format!("clock_s,level_m\n{rows}")).unwrap();
    let mut output = Vec::new();
    look(&[path, column, pair], None, &mut output, &mut |_| {}).unwrap();
    let shown = String::from_utf8(output).unwrap();
    let one = shown
        .split("one.txt")
        .nth(1)
        .unwrap()
        .split("pair.csv")
        .next()
        .unwrap();
    assert!(!one.contains("separated by"), "{shown}");
    assert!(
        !shown.contains("@clock_s") && !shown.contains("@Time\\t"),
        "{shown}"
    );
}

#[test]
fn a_guessed_exploration_is_one_of_the_recording_or_is_checked() {
    // A rig with strokes of 0.8 s in a long record, and a stick that only twitches.
    for (name, is_twitching) in [("S1_T1.csv", false), ("S1_T2.csv", true)] {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        let mut text = "time_s,Fn_N,Ft_N,x_mm\n".to_owned();
        for n in 0..60_000 {
            let t = f64::from(n) / 200.0;
            let phase = (t % 2.4) / 2.4;
            let x = match (is_twitching, phase) {
                (true, _) => 0.1 * (t / 0.4).floor().rem_euclid(40.0),
                (false, phase) if phase < 1.0 / 3.0 => 0.3 * 3.0 * phase,
                (false, phase) if phase < 0.5 => 0.3,
                (false, phase) if phase < 5.0 / 6.0 => 0.3 * (2.5 - 3.0 * phase),
                _ => 0.0,
            };
            let [normal, lateral] = [0.3 + 0.01 * noise(n as usize), 0.1 * noise(n as usize + 1)];
            writeln!(text, "{t:.4},{normal:.4},{lateral:.4},{x:.5}").unwrap();
        }
        std::fs::write(&path, text).unwrap();
        let (text, _) = guessed(&[path]);
        let rule = line(&text, "intervals", "exploration");
        match is_twitching {
            true => assert!(is_checked(rule), "{text}"),
            // 0.3 mm in 0.8 s.
            false => assert!(
                rule.starts_with("exploration = \"0.26 to 0.49 mm/s for 0.5 s\"")
                    && !is_checked(rule),
                "{text}"
            ),
        }
        // The normal force never rests.
        let unloaded = line(&text, "intervals", "unloaded");
        assert!(
            unloaded.contains("no stretch looked at keeps to this rule"),
            "{text}"
        );
    }
}

#[test]
fn clocks_are_one_where_one_file_shows_one_start_or_one_rate() {
    let rate = 100e3;
    let signals = samples(rate, |n, _| electrical(n, rate, 33e3));
    let forces = samples(5e3, |n, t| FINGER.forces_n(n, t));
    let guessed_clock = |drive_start: Option<f64>, force_start: Option<f64>| {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("S6_T6.tdms");
        let mut file = Tdms::default();
        let properties = |interval: f64, start: Option<f64>| {
            let mut list = vec![Property::Number("wf_increment", interval)];
            list.extend(start.map(|start| Property::Number("wf_start_time", start)));
            list
        };
        let column =
            |index: usize| TdmsValues::Floats(signals.iter().map(|row| row[index]).collect());
        file.add("d/drive", &column(0), &properties(1.0 / rate, drive_start));
        file.add("d/ldv", &column(1), &properties(1.0 / rate, drive_start));
        let column =
            |index: usize| TdmsValues::Floats(forces.iter().map(|row| row[index]).collect());
        file.add("f/Fn", &column(0), &properties(2e-4, force_start));
        file.add("f/Ft", &column(1), &properties(2e-4, force_start));
        file.write(&path);
        let (text, _) = guessed(&[path]);
        let line = line(&text, "normal", "clock");
        (line.contains("\"same\""), is_checked(line))
    };
    assert_eq!(guessed_clock(Some(3.7e9), Some(3.7e9)), (true, false));
    assert_eq!(
        guessed_clock(Some(3.7e9), Some(3.7e9 + 0.3)),
        (false, false)
    );
    assert_eq!(guessed_clock(None, None), (false, false));
}
