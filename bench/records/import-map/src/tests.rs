//! Maps as people write them.

use crate::{
    Carrier, ComplexArrays, Electrical, ImportMap, Intervals, LateralTare, MapErrors, NormalTare,
    PickupScale, PlateConstants, Quantity, Rate, Tier, TimeBase, Travel,
};

const SIGNALS: &str = r#"
format = 1
files = 'S(?<participant>\d+)_T(?<trial>\d+)\.mat'
[carrier]
hz = "found"
[modulation]
hz = 6.0
index = 0.95
[drive]
from = "out[:,0]"
rate_hz = "sr"
volts_per_unit = 20.0
[pickup]
from = "out[:,1]"
quantity = "displacement"
metres_per_unit = 2.0e-6
skew_s = 4.0e-6
phase_rad = "found"
[normal]
from = "F[:,2]"
rate_hz = 10e3
newtons_per_unit = -0.31
tare = "no contact"
clock = "own"
offset_s = "found"
ppm = "found"
[lateral]
from = "F[:,0]"
newtons_per_unit = 0.444
tare = "symmetric strokes"
[position]
from = "enc"
metres_per_unit = 5.0e-7
wrap_bits = 32
[plate]
modal_mass_kg = 8.0e-3
resonance_hz = 35000
force_factor_n_per_v = 0.13
[intervals]
unloaded = "normal < 0.05 N for 0.3 s"
exploration = "40 to 60 mm/s for 0.5 s"
[participants]
table = "people.csv"
"#;

fn parse(text: &str) -> Result<ImportMap, MapErrors> {
    ImportMap::parse(text, "map.toml")
}

/// Returns the errors of the map with `from` replaced by `to`.
fn errors(from: &str, to: &str) -> String {
    assert!(SIGNALS.contains(from), "{from}");
    parse(&SIGNALS.replace(from, to)).unwrap_err().to_string()
}

#[test]
fn a_map_of_signals_is_read_with_its_defaults() {
    let map = parse(SIGNALS).unwrap();
    assert_eq!(map.tier(), Tier::A);
    let Electrical::Signals {
        carrier,
        drive,
        pickup,
        plate,
        ..
    } = &map.electrical
    else {
        panic!("{:?}", map.electrical);
    };
    assert_eq!(*carrier, Carrier::Constant(Quantity::Found));
    assert_eq!(drive.time, TimeBase::Rate(Rate::Scalar("sr".to_owned())));
    assert_eq!(pickup.conversion.scale, PickupScale::MetresPerUnit(2e-6));
    assert_eq!(pickup.conversion.phase_rad, Quantity::Found);
    assert!(matches!(
        plate.constants,
        PlateConstants::Stated { quality: None, .. }
    ));
    let (normal, lateral) = (map.normal.unwrap(), map.lateral.unwrap());
    assert_eq!(normal.tare, NormalTare::NoContact);
    assert_eq!(lateral.tare, LateralTare::SymmetricStrokes);
    assert_eq!((&lateral.time, lateral.clock), (&normal.time, normal.clock));
    let position = map.position.unwrap();
    assert_eq!(position.clock, normal.clock);
    assert_eq!(
        position.travel,
        Travel::Position {
            metres_per_unit: 5e-7,
            wrap_bits: Some(32)
        }
    );
    assert!(matches!(
        map.intervals,
        Intervals::Rules {
            unloaded: Some(_),
            exploration: Some(_)
        }
    ));
}

#[test]
fn files_follow_the_streams_where_no_pattern_is_stated() {
    let map = parse(
        r#"
        format = 1
        normal = { file = "f_{participant}_{trial}.csv", from = 2, time = "t", seconds_per_unit = 1e-3, newtons_per_unit = 1 }
        lateral = { file = "f_{participant}_{trial}.csv", from = 1, newtons_per_unit = 1, clock = "same" }
        velocity = { file = "v_{participant}_{trial}.csv", from = "v" }
        contact = { body = "other" }
        "#,
    )
    .unwrap();
    assert_eq!(map.tier(), Tier::C);
    let captures = map.pattern.captures("f_AB_12.csv").unwrap();
    let position = map.position.unwrap();
    assert_eq!(position.source.file.unwrap().fill(&captures), "v_AB_12.csv");
    assert_eq!(map.normal.unwrap().source.name, "2");
    assert!(map.lateral.unwrap().clock.is_drives);
}

#[test]
fn a_place_holds_for_all_files_unless_their_names_state_it() {
    let stated = SIGNALS.replacen(
        "[carrier]",
        "[place]\nsession = 2\ncondition = \"wet\"\n[carrier]",
        1,
    );
    let map = parse(&stated).unwrap();
    let captures = map.pattern.captures("S7_T3.mat").unwrap();
    assert_eq!(
        (&*captures["session"], &*captures["condition"]),
        ("2", "wet")
    );
    assert_eq!(&*captures["trial"], "3");
    let twice = stated.replace("session = 2", "trial = 2");
    let errors = parse(&twice).unwrap_err().to_string();
    assert!(errors.contains("place.trial"), "{errors}");
}

#[test]
fn envelopes_are_read_in_every_form() {
    let text = r#"
        format = 1
        files = 'r(?<trial>\d+)\.csv'
        carrier.hz = 35e3
        modulation = { hz = 6, index = "found" }
        plate = { modal_mass_kg = 8e-3, sweep = "sweep.csv" }
        [envelopes]
        drive = ["U_x", "U_y"]
        pickup = { amplitude = "R", phase_rad = "theta" }
        rate_hz = 10e3
        volts_per_unit = 1
        metres_per_unit = "from modal mass"
        quantity = "velocity"
        convention = "exp(-iwt)"
        rms = true
        low_pass = { order = 4, tau_s = 1e-4 }
    "#;
    assert_eq!(parse(text).unwrap().tier(), Tier::B);
    assert!(parse(&text.replace(r#"["U_x", "U_y"]"#, r#""U""#)).is_ok());
    let errors = |old: &str, new: &str| parse(&text.replace(old, new)).unwrap_err().to_string();
    assert!(errors("35e3", "\"found\"").contains("carrier.hz"));
    assert!(errors("rms = true", "").contains("[envelopes]: `rms` is missing"));
    assert!(errors("order = 4", "order = 40").contains("low_pass.order"));
    assert!(errors("theta\" }", "theta\", x = \"y\" }").contains("unknown key"));
    assert!(errors("theta\" }", "theta\", phase_deg = \"y\" }").contains("phase_deg"));
    let map = parse(&text.replace("phase_rad", "phase_deg")).unwrap();
    let Electrical::Envelopes { envelopes, .. } = map.electrical else {
        panic!("{map:?}");
    };
    let ComplexArrays::Polar { rad_per_unit, .. } = envelopes.pickup else {
        panic!("{envelopes:?}");
    };
    assert!((rad_per_unit - 1f64.to_radians()).abs() < 1e-15);
}

#[test]
fn a_missing_key_is_named_with_what_to_write() {
    for (line, named) in [
        (
            "files = 'S(?<participant>\\d+)_T(?<trial>\\d+)\\.mat'",
            "`files` is missing",
        ),
        ("hz = \"found\"", "table [carrier]: `hz` is missing"),
        ("index = 0.95", "table [modulation]: `index`"),
        ("rate_hz = \"sr\"", "table [drive]: `rate_hz`"),
        ("volts_per_unit = 20.0", "table [drive]: `volts_per_unit`"),
        ("quantity = \"displacement\"", "table [pickup]: `quantity`"),
        (
            "metres_per_unit = 2.0e-6",
            "table [pickup]: `metres_per_unit`",
        ),
        (
            "newtons_per_unit = -0.31",
            "table [normal]: `newtons_per_unit`",
        ),
        (
            "metres_per_unit = 5.0e-7",
            "table [position]: `metres_per_unit`",
        ),
        ("modal_mass_kg = 8.0e-3", "table [plate]: `modal_mass_kg`"),
        ("resonance_hz = 35000", "table [plate]: `resonance_hz`"),
        ("from = \"enc\"", "table [position]: `from`"),
    ] {
        let text = errors(line, "");
        assert!(
            text.contains(named) && !text.contains('\n'),
            "{line}: {text}"
        );
    }
}

#[test]
fn contradictions_are_refused_with_their_line() {
    for (from, to, named) in [
        (
            "clock = \"own\"",
            "clock = \"same\"",
            "map.toml, line 26: normal.ppm contradicts clock",
        ),
        (
            "rate_hz = 10e3",
            "rate_hz = 10e3\ntime = \"t\"",
            "both state the times",
        ),
        (
            "newtons_per_unit = -0.31",
            "newtons_per_unit = 0",
            "normal.newtons_per_unit = 0",
        ),
        (
            "skew_s = 4.0e-6",
            "skew_s = 4.0",
            "pickup.skew_s is no skew of one converter",
        ),
        (
            "index = 0.95",
            "index = 95",
            "modulation.index = 95 is outside 0 to 1",
        ),
        (
            "normal < 0.05 N for 0.3 s",
            "normal < 0.05 for 0.3 s",
            "intervals.unloaded",
        ),
        (
            "[intervals]",
            "[intervals]\nmarks = \"marks.csv\"",
            "both state intervals",
        ),
        (
            "[position]",
            "[velocity]\nfrom = \"v\"\n[position]",
            "both state the place",
        ),
        ("hz = \"found\"", "hz = \"follows\"", "`quality` is missing"),
        (
            "tare = \"no contact\"",
            "tare = \"symmetric strokes\"",
            "unknown value `symmetric strokes`",
        ),
        (
            "from = \"enc\"",
            "from = \"enc\"\nfile = 'e_{partcipant}.csv'",
            "did you mean {participant}?",
        ),
        (
            "(?<participant>",
            "(?<particpant>",
            "did you mean `participant`?",
        ),
        (
            "wrap_bits = 32",
            "wrap_bits = 32\noffset_s = \"found\"",
            "is found for [normal]",
        ),
        ("skew_s", "skew", "did you mean `skew_s`?"),
        ("format = 1", "format = 2", "write format = 1"),
    ] {
        let text = errors(from, to);
        assert!(text.contains(named), "{to}: {text}");
    }
    let several = errors("volts_per_unit = 20.0", "").lines().count()
        + parse(
            &SIGNALS
                .replace("volts_per_unit = 20.0", "")
                .replace("index = 0.95", ""),
        )
        .unwrap_err()
        .0
        .len();
    assert_eq!(several, 3, "all errors are reported at once");
}

#[test]
fn a_table_without_its_partner_is_refused() {
    let shortened = |table: &str| {
        let start = SIGNALS.find(table).unwrap();
        let end = SIGNALS[start + 1..]
            .find("\n[")
            .map(|end| start + 1 + end)
            .unwrap();
        SIGNALS[..start].to_owned() + &SIGNALS[end..]
    };
    let text = parse(&shortened("[pickup]")).unwrap_err().to_string();
    assert!(text.contains("`pickup` is missing"), "{text}");
    let text = parse(&shortened("[drive]")).unwrap_err().to_string();
    assert!(text.contains("`drive` is missing"), "{text}");
    assert!(parse(&shortened("[lateral]")).is_ok());
    let text = parse("format = 1\nfiles = 'x'\n").unwrap_err().to_string();
    assert!(text.contains("[normal] and [lateral]"), "{text}");
}
