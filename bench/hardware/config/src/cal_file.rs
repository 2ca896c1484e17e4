//! Calibration file from the maker of a six-axis sensor: XML with a row per axis, as delivered by ATI (`.cal`), of version 1.0
//! (`Axis` rows with scales, and `BasicTransform`) or 1.1 (`UserAxis` rows, which have both applied).

use std::path::Path;

use roxmltree::{Document, Node};

const AXES: [&str; 6] = ["Fx", "Fy", "Fz", "Tx", "Ty", "Tz"];

/// Newtons per unit of force; pound-force and kilogram-force by NIST SP 811.
const FORCE_UNITS: [(&str, f64); 10] = [
    ("n", 1.0),
    ("kn", 1e3),
    ("lbf", N_PER_LBF),
    ("lb", N_PER_LBF),
    ("klbf", 1e3 * N_PER_LBF),
    ("klb", 1e3 * N_PER_LBF),
    ("kgf", N_PER_KGF),
    ("kg", N_PER_KGF),
    ("gf", 1e-3 * N_PER_KGF),
    ("g", 1e-3 * N_PER_KGF),
];
const N_PER_LBF: f64 = 4.448_221_615_260_5;
const N_PER_KGF: f64 = 9.806_65;

/// Metres per unit of length.
const LENGTH_UNITS: [(&str, f64); 5] = [
    ("m", 1.0),
    ("cm", 1e-2),
    ("mm", 1e-3),
    ("in", 0.0254),
    ("ft", 0.3048),
];

/// Contents of a maker's calibration file.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct MakersMatrix {
    /// Newtons, and newton metres, per volt of each gauge, rows Fx, Fy, Fz, Tx, Ty, Tz.
    pub(crate) rows: Vec<Vec<f64>>,
    /// Serial number.
    pub(crate) serial: Option<String>,
}

/// Reason why a maker's file cannot be used.
#[derive(Debug, thiserror::Error)]
pub(crate) enum CalFileError {
    #[error("it cannot be read")]
    Read(#[from] std::io::Error),
    #[error("it is not XML")]
    NotXml(#[from] roxmltree::Error),
    #[error(
        "it is the file of a Net F/T, which sends forces over the network and has no gauges on the card: write source = \"netft\" in \
         [force], and the sensor's address in [force.netft]"
    )]
    NetFt,
    #[error(
        "it has neither a row <UserAxis Name=\"{0}\" values=\"…\"> nor a row <Axis Name=\"{0}\" values=\"…\" scale=\"…\">: type \
         newtons_per_v instead"
    )]
    NoRow(&'static str),
    #[error("\"{value}\" in the row of {axis} is not a number")]
    NotANumber { axis: &'static str, value: String },
    #[error("the row of {axis} has {found} numbers, and that of Fx has {expected}")]
    Columns {
        axis: &'static str,
        found: usize,
        expected: usize,
    },
    #[error("its {attribute} are {unit}: {known} are known; type newtons_per_v instead")]
    Unit {
        attribute: &'static str,
        unit: String,
        known: &'static str,
    },
    #[error(
        "its BasicTransform has {attribute} = {value}: only a shift in Dx, Dy and Dz is read; type newtons_per_v instead"
    )]
    Transform {
        attribute: &'static str,
        value: String,
    },
    #[error(
        "its GainMultiplier is {0}: type newtons_per_v, in newtons per volt at the inputs, instead"
    )]
    Gain(String),
}

/// Returns an error's text with its causes.
pub(crate) fn in_words(error: &CalFileError) -> String {
    let causes = std::iter::successors(std::error::Error::source(error), |cause| cause.source());
    let causes: String = causes.map(|cause| format!(": {cause}")).collect();
    format!("{error}{causes}")
}

impl MakersMatrix {
    pub(crate) fn read(path: &Path) -> Result<Self, CalFileError> {
        Self::parse(&bounded_files::read_text(
            path,
            bounded_files::TEXT_LIMIT_BYTES,
        )?)
    }

    fn parse(text: &str) -> Result<Self, CalFileError> {
        let xml = Document::parse(text.trim_start_matches('\u{feff}').trim())?;
        if belongs_to_net_ft(&xml) {
            return Err(CalFileError::NetFt);
        }
        let newtons = unit_factor(
            &FORCE_UNITS,
            "ForceUnits",
            attribute(&xml, "ForceUnits"),
            "N, lbf and kgf",
        )?;
        if let Some(gain) = attribute(&xml, "GainMultiplier")
            && gain.trim().parse() != Ok(1.0)
        {
            return Err(CalFileError::Gain(gain.to_owned()));
        }
        let newton_metres = torque_factor(attribute(&xml, "TorqueUnits"))?;
        let has_user_axes = xml.descendants().any(|node| node.has_tag_name("UserAxis"));
        let mut rows = AXES
            .into_iter()
            .map(|axis| {
                let unit = if axis.starts_with('F') {
                    newtons
                } else {
                    newton_metres
                };
                read_row(&xml, axis, has_user_axes, unit)
            })
            .collect::<Result<Vec<_>, _>>()?;
        let expected = rows.first().map_or(0, Vec::len);
        for (axis, row) in AXES.into_iter().zip(&rows) {
            if row.len() != expected {
                let found = row.len();
                return Err(CalFileError::Columns {
                    axis,
                    found,
                    expected,
                });
            }
        }
        if !has_user_axes {
            shift_torques(&mut rows, origin_m(&xml)?);
        }
        Ok(Self {
            rows,
            serial: attribute(&xml, "Serial").map(str::to_owned),
        })
    }
}

/// Returns whether the file is of a Net F/T: its calibration, the one that the box keeps, or the box's page.
fn belongs_to_net_ft(xml: &Document<'_>) -> bool {
    let root_name = xml.root_element().tag_name().name().to_ascii_lowercase();
    let is_net = |family: &str| family.to_ascii_lowercase().contains("net f");
    let mut families = xml.descendants().filter_map(|node| {
        let text = node.text().filter(|_| node.has_tag_name("Family"));
        node.attribute("Family").or(text)
    });
    root_name.contains("netft") || families.any(is_net)
}

/// Returns the row of an axis in SI units per volt.
fn read_row(
    xml: &Document<'_>,
    axis: &'static str,
    has_user_axes: bool,
    unit: f64,
) -> Result<Vec<f64>, CalFileError> {
    let tag = if has_user_axes { "UserAxis" } else { "Axis" };
    let is_row =
        |node: &Node<'_, '_>| node.has_tag_name(tag) && node.attribute("Name") == Some(axis);
    let number = |text: &str| match text.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(CalFileError::NotANumber {
            axis,
            value: text.to_owned(),
        }),
    };
    let node = xml.descendants().find(is_row);
    let node = node.ok_or(CalFileError::NoRow(axis))?;
    let values = node.attribute("values").ok_or(CalFileError::NoRow(axis))?;
    let scale = if has_user_axes {
        1.0
    } else {
        let text = node.attribute("scale").ok_or(CalFileError::NoRow(axis))?;
        match number(text.trim())? {
            0.0 => return Err(CalFileError::NoRow(axis)),
            scale => scale,
        }
    };
    values
        .split_whitespace()
        .map(|value| Ok(unit * number(value)? / scale))
        .collect()
}

/// Returns the origin that the file's `BasicTransform` moves the torques to, m; zero without one.
fn origin_m(xml: &Document<'_>) -> Result<[f64; 3], CalFileError> {
    let mut nodes = xml.descendants();
    let Some(node) = nodes.find(|node| node.has_tag_name("BasicTransform")) else {
        return Ok([0.0; 3]);
    };
    let value = |attribute: &'static str| -> Result<f64, CalFileError> {
        let text = node.attribute(attribute).unwrap_or("0");
        let value = text.trim().parse::<f64>().ok();
        value
            .filter(|value| value.is_finite())
            .ok_or_else(|| CalFileError::Transform {
                attribute,
                value: text.to_owned(),
            })
    };
    for attribute in ["Rx", "Ry", "Rz"] {
        let value = value(attribute)?;
        if value != 0.0 {
            return Err(CalFileError::Transform {
                attribute,
                value: value.to_string(),
            });
        }
    }
    let shift = [value("Dx")?, value("Dy")?, value("Dz")?];
    if shift == [0.0; 3] {
        return Ok(shift);
    }
    let metres = unit_factor(
        &LENGTH_UNITS,
        "DistUnits",
        attribute(xml, "DistUnits"),
        "m, mm and in",
    )?;
    Ok(shift.map(|value| metres * value))
}

/// Moves the torques to `origin_m`: T − d × F of each gauge.
fn shift_torques(rows: &mut [Vec<f64>], origin_m: [f64; 3]) {
    let [x, y, z] = origin_m;
    let [fx, fy, fz, tx, ty, tz] = rows else {
        return;
    };
    for (gauge, ((fx, fy), fz)) in fx.iter().zip(&*fy).zip(&*fz).enumerate() {
        tx[gauge] -= y * fz - z * fy;
        ty[gauge] -= z * fx - x * fz;
        tz[gauge] -= x * fy - y * fx;
    }
}

/// Returns the SI units per unit named by an attribute of the file.
fn unit_factor(
    units: &[(&str, f64)],
    attribute: &'static str,
    stated: Option<&str>,
    known: &'static str,
) -> Result<f64, CalFileError> {
    let stated = stated.map_or("not stated", str::trim);
    let name = stated.to_ascii_lowercase();
    let unit = units.iter().find(|(unit, _)| *unit == name);
    unit.map(|(_, factor)| *factor)
        .ok_or_else(|| CalFileError::Unit {
            attribute,
            unit: stated.to_owned(),
            known,
        })
}

/// Returns newton metres per unit of torque, such as `N-mm`, `lbf-in` or `Nm`; 1 if the file states none, because the bench
/// uses no torque.
fn torque_factor(stated: Option<&str>) -> Result<f64, CalFileError> {
    let Some(stated) = stated.map(str::trim) else {
        return Ok(1.0);
    };
    let name = stated.to_ascii_lowercase();
    let factor = |name: &str, units: &[(&str, f64)]| {
        let unit = units.iter().find(|(unit, _)| *unit == name);
        unit.map(|(_, factor)| *factor)
    };
    let product = |force: &str, length: &str| {
        Some(factor(force, &FORCE_UNITS)? * factor(length, &LENGTH_UNITS)?)
    };
    let in_parts = |(first, second): (&str, &str)| {
        let (first, second) = (first.trim(), second.trim());
        product(first, second).or_else(|| product(second, first))
    };
    let separated = name.split_once(['-', '*', '.', '·', ' ']);
    separated
        .and_then(in_parts)
        .or_else(|| product("n", name.strip_prefix('n')?))
        .ok_or_else(|| CalFileError::Unit {
            attribute: "TorqueUnits",
            unit: stated.to_owned(),
            known: "N-m, N-mm and lbf-in",
        })
}

/// Returns the first attribute of this name.
fn attribute<'a>(xml: &'a Document<'_>, name: &str) -> Option<&'a str> {
    xml.descendants().find_map(|node| node.attribute(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file in the form that ATI describes for its DAQ sensors, with invented numbers.
    const FILE: &str = include_str!("../tests/data/FT09999.cal");

    #[test]
    fn the_user_axes_are_the_matrix() {
        let makers = MakersMatrix::parse(FILE).unwrap();
        assert_eq!(makers.serial.as_deref(), Some("FT09999"));
        assert_eq!(makers.rows.len(), 6);
        assert_eq!(makers.rows[2], [1.88, -0.01, 1.9, -0.06, 1.87, -0.02]);
        let pounds = FILE.replace("ForceUnits=\"N\"", "ForceUnits=\"lbf\"");
        let pounds = MakersMatrix::parse(&pounds).unwrap();
        assert!((pounds.rows[2][0] - 1.88 * N_PER_LBF).abs() < 1e-12);
        assert_eq!(pounds.rows[3], makers.rows[3]);
        assert!((makers.rows[3][0] - 0.1e-3).abs() < 1e-12);
        let inches = FILE.replace("TorqueUnits=\"N-mm\"", "TorqueUnits=\"lbf-in\"");
        let inches = MakersMatrix::parse(&inches).unwrap();
        assert!((inches.rows[3][0] - 0.1 * 0.112_984_829).abs() < 1e-9);
    }

    /// A matrix of two gauges, written as version 1.1 and, with scales and at the sensor's inner origin, as version 1.0.
    #[test]
    fn both_versions_of_a_file_are_the_same_matrix() {
        let forces = [[0.5, 2.0], [1.5, -1.0], [4.0, 3.0]];
        let torques = [[0.01, 0.02], [-0.03, 0.04], [0.05, -0.06]];
        let scales = [8.0, 8.0, 2.5, 300.0, 300.0, 320.0];
        let origin = [0.001, -0.002, 0.006];
        let file = |version: &str, rows: String| {
            format!(
                "<FTSensor Serial=\"FT00001\" Family=\"DAQ\" CalFileVersion=\"{version}\"><Calibration ForceUnits=\"N\" \
                 TorqueUnits=\"N-m\" DistUnits=\"mm\">{rows}<BasicTransform Dx=\"1\" Dy=\"-2\" Dz=\"6\" Rx=\"0\" \
                 Ry=\"0\" Rz=\"0\"/></Calibration></FTSensor>"
            )
        };
        let row = |tag: &str, axis: usize, values: [f64; 2], scale: f64| {
            let [first, second] = values.map(|value| value * scale);
            let name = AXES[axis];
            format!("<{tag} Name=\"{name}\" values=\" {first}  {second} \" scale=\"{scale}\"/>")
        };
        let user: Vec<[f64; 2]> = forces.into_iter().chain(torques).collect();
        let user_rows: String = (0..6).map(|i| row("UserAxis", i, user[i], 1.0)).collect();
        let mut inner = user.clone();
        for gauge in 0..2 {
            let force = forces.map(|row| row[gauge]);
            for axis in 0..3 {
                let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
                inner[3 + axis][gauge] += origin[next] * force[last] - origin[last] * force[next];
            }
        }
        let inner_rows: String = (0..6)
            .map(|i| row("Axis", i, inner[i], scales[i]))
            .collect();
        let newer = MakersMatrix::parse(&file("1.1", user_rows)).unwrap();
        let older = MakersMatrix::parse(&file("1.0", inner_rows.clone())).unwrap();
        assert_eq!(older.serial, newer.serial);
        for (older, newer) in older.rows.concat().iter().zip(newer.rows.concat()) {
            assert!((older - newer).abs() < 1e-12, "{older} {newer}");
        }
        let turned = file("1.0", inner_rows.clone()).replace("Rz=\"0\"", "Rz=\"90\"");
        let turned = MakersMatrix::parse(&turned).unwrap_err();
        assert!(turned.to_string().contains("Rz = 90"), "{turned}");
        let unscaled = file("1.0", inner_rows.replace("scale=", "max="));
        let unscaled = MakersMatrix::parse(&unscaled).unwrap_err();
        assert!(matches!(unscaled, CalFileError::NoRow("Fx")));
    }

    #[test]
    fn the_file_of_a_net_ft_is_named() {
        for file in [
            FILE.replace("Family=\"DAQ\"", "Family=\"Net F/T\""),
            FILE.replace("FTSensor", "NetFTSensor"),
            "<dsNetFTCalibrationFile><a><Family>Net F/T</Family></a></dsNetFTCalibrationFile>"
                .to_owned(),
            "<netft><cfgcpf>1000000</cfgcpf></netft>".to_owned(),
        ] {
            let error = MakersMatrix::parse(&file).unwrap_err();
            assert!(matches!(error, CalFileError::NetFt), "{error}");
        }
    }

    #[test]
    fn an_invalid_file_is_refused_with_its_fault() {
        let refusal = |original: &str, replacement: &str| {
            assert!(FILE.contains(original));
            MakersMatrix::parse(&FILE.replacen(original, replacement, 1)).unwrap_err()
        };
        let no_row = refusal("UserAxis Name=\"Fz\"", "UserAxis Name=\"Fq\"");
        assert!(matches!(no_row, CalFileError::NoRow("Fz")));
        let word = refusal("1.88000", "1,88000");
        assert!(matches!(word, CalFileError::NotANumber { axis: "Fz", .. }));
        let infinite = refusal("1.88000", "inf");
        assert!(matches!(infinite, CalFileError::NotANumber { .. }));
        let unit = refusal("ForceUnits=\"N\"", "ForceUnits=\"stone\"");
        assert!(matches!(unit, CalFileError::Unit { .. }));
        let unit = refusal("ForceUnits=\"N\"", "");
        assert!(unit.to_string().contains("not stated"));
        let unit = refusal("TorqueUnits=\"N-mm\"", "TorqueUnits=\"N-yard\"");
        assert!(unit.to_string().contains("TorqueUnits are N-yard"));
        let columns = refusal("1.88000", "1.88000 2.0");
        assert!(matches!(columns, CalFileError::Columns { axis: "Fz", .. }));
        let gain = refusal("GainMultiplier=\"1\"", "GainMultiplier=\"4\"");
        assert!(matches!(gain, CalFileError::Gain(_)));
        let truncated = MakersMatrix::parse(&FILE[..900]).unwrap_err();
        assert!(matches!(truncated, CalFileError::NotXml(_)));
        let bomb = "<!DOCTYPE a [<!ENTITY b \"c\">]><a>&b;</a>";
        assert!(MakersMatrix::parse(bomb).is_err());
    }
}
