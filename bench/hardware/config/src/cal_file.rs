//! Calibration file from the maker of a six-axis sensor: XML with a `UserAxis` row per axis, as delivered by ATI (`.cal`).

use std::path::Path;

use roxmltree::{Document, Node};

/// Newtons per pound-force (NIST SP 811).
const N_PER_LBF: f64 = 4.448_221_615_260_5;
const AXES: [&str; 6] = ["Fx", "Fy", "Fz", "Tx", "Ty", "Tz"];

/// Contents of a maker's calibration file.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct MakersMatrix {
    /// Newtons per volt of each gauge, rows Fx, Fy, Fz, Tx, Ty, Tz; torques in the file's own unit.
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
    #[error("it has no row <UserAxis Name=\"{0}\" values=\"…\">")]
    NoRow(&'static str),
    #[error("\"{value}\" in the row of {axis} is not a number")]
    NotANumber { axis: &'static str, value: String },
    #[error("its ForceUnits are {0}: N and lbf are known; type newtons_per_v instead")]
    Unit(String),
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
        let unit = attribute(&xml, "ForceUnits");
        let newtons = match unit.unwrap_or("none stated") {
            "N" => 1.0,
            "lbf" | "lb" => N_PER_LBF,
            other => return Err(CalFileError::Unit(other.to_owned())),
        };
        if let Some(gain) = attribute(&xml, "GainMultiplier")
            && gain.trim().parse() != Ok(1.0)
        {
            return Err(CalFileError::Gain(gain.to_owned()));
        }
        let row = |axis: &'static str| -> Result<Vec<f64>, CalFileError> {
            let is_row = |node: &Node<'_, '_>| {
                node.has_tag_name("UserAxis") && node.attribute("Name") == Some(axis)
            };
            let values = xml.descendants().find(is_row);
            let values = values.and_then(|node| node.attribute("values"));
            let values = values.ok_or(CalFileError::NoRow(axis))?;
            let scale = if axis.starts_with('F') { newtons } else { 1.0 };
            values
                .split_whitespace()
                .map(|value| match value.parse::<f64>() {
                    Ok(number) if number.is_finite() => Ok(scale * number),
                    _ => Err(CalFileError::NotANumber {
                        axis,
                        value: value.to_owned(),
                    }),
                })
                .collect()
        };
        Ok(Self {
            rows: AXES.into_iter().map(row).collect::<Result<_, _>>()?,
            serial: attribute(&xml, "Serial").map(str::to_owned),
        })
    }
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
    }

    #[test]
    fn an_invalid_file_is_refused_with_its_fault() {
        let refusal = |from: &str, to: &str| {
            assert!(FILE.contains(from));
            MakersMatrix::parse(&FILE.replacen(from, to, 1)).unwrap_err()
        };
        let no_row = refusal("UserAxis Name=\"Fz\"", "UserAxis Name=\"Fq\"");
        assert!(matches!(no_row, CalFileError::NoRow("Fz")));
        let word = refusal("1.88000", "1,88000");
        assert!(matches!(word, CalFileError::NotANumber { axis: "Fz", .. }));
        let infinite = refusal("1.88000", "inf");
        assert!(matches!(infinite, CalFileError::NotANumber { .. }));
        let unit = refusal("ForceUnits=\"N\"", "ForceUnits=\"kg\"");
        assert!(matches!(unit, CalFileError::Unit(_)));
        let unit = refusal("ForceUnits=\"N\"", "");
        assert!(matches!(unit, CalFileError::Unit(_)));
        let gain = refusal("GainMultiplier=\"1\"", "GainMultiplier=\"4\"");
        assert!(matches!(gain, CalFileError::Gain(_)));
        let truncated = MakersMatrix::parse(&FILE[..900]).unwrap_err();
        assert!(matches!(truncated, CalFileError::NotXml(_)));
        let bomb = "<!DOCTYPE a [<!ENTITY b \"c\">]><a>&b;</a>";
        assert!(MakersMatrix::parse(bomb).is_err());
    }
}
