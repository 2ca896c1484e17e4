//! The simulated bench with the equipment of a written configuration, so that its owner can try it without the hardware.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use mock_world::scenario::{ForceInterface, ForceLineFormat, Scenario, built_in, built_in_text};

/// First input of the simulated card that reads a gauge: the one before it reads the generator.
pub(crate) const FIRST_GAUGE: u16 = 3;
/// Delay of the simulated gauges' amplifier, s.
pub(crate) const GAUGES_DELAY_S: f64 = 2e-4;
/// Range of the simulated gauges' inputs, V.
pub(crate) const GAUGES_RANGE_V: f64 = 10.0;

/// Equipment that a simulated bench must have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Equipment {
    pub(crate) interface: ForceInterface,
    pub(crate) protocol: ForceLineFormat,
    /// Whether a field box without forces has the encoder and the digital lines.
    pub(crate) box_beside: bool,
    /// Number of the card's inputs.
    pub(crate) inputs: u16,
}

impl Equipment {
    fn is_in(self, scenario: &Scenario) -> bool {
        let sensor = &scenario.force_sensor;
        let is_same_line =
            self.interface != ForceInterface::Serial || sensor.protocol == self.protocol;
        sensor.interface == self.interface
            && sensor.box_beside == self.box_beside
            && is_same_line
            && scenario.converter.channels >= usize::from(self.inputs)
    }

    /// Returns the entries of the table `force_sensor`, with the usual rates of such a sensor.
    fn entries(self) -> toml::Table {
        let (interface, rates): (&str, &[(&str, f64)]) = match (self.interface, self.protocol) {
            (ForceInterface::Serial, ForceLineFormat::Frames) => ("serial", &[]),
            (ForceInterface::Serial, ForceLineFormat::Lines) => {
                ("serial", &[("rate_hz", 1000.0), ("resonance_hz", 300.0)])
            }
            (ForceInterface::Netft, _) => ("netft", &[("rate_hz", 7000.0)]),
            (ForceInterface::Gauges, _) => ("gauges", &[]),
            (ForceInterface::FieldBox, _) => (
                "field-box",
                &[("rate_hz", 4000.0), ("burst_period_s", 0.001)],
            ),
        };
        let mut entries = toml::Table::new();
        for (key, value) in rates {
            entries.insert((*key).to_owned(), (*value).into());
        }
        entries.insert("interface".to_owned(), interface.into());
        if self.interface == ForceInterface::Serial {
            let protocol = match self.protocol {
                ForceLineFormat::Frames => "frames",
                ForceLineFormat::Lines => "lines",
            };
            entries.insert("protocol".to_owned(), protocol.into());
        }
        entries.insert("box_beside".to_owned(), self.box_beside.into());
        entries
    }

    /// Returns a scenario as text with this equipment; `None` if `text` has it already.
    fn added_to(self, text: &str, name: &str) -> anyhow::Result<Option<String>> {
        if self.is_in(&Scenario::parse(text, name)?) {
            return Ok(None);
        }
        let mut scenario: toml::Table = toml::from_str(text)?;
        let mut put = |table: &str, entries: toml::Table| {
            let place = scenario
                .entry(table)
                .or_insert_with(|| toml::Table::new().into());
            if let Some(place) = place.as_table_mut() {
                place.extend(entries);
            }
        };
        put("force_sensor", self.entries());
        if Scenario::parse(text, name)?.converter.channels < usize::from(self.inputs) {
            let channels = i64::from(self.inputs);
            put(
                "converter",
                toml::Table::from_iter([("channels".to_owned(), channels.into())]),
            );
        }
        let text = format!(
            "# The simulated bench `{name}` with the equipment that `friction-bench init` was told of.\n{}",
            toml::to_string(&scenario)?
        );
        Scenario::parse(&text, name)?;
        Ok(Some(text))
    }
}

/// Returns the scenario, by name or path, of a simulated bench with this equipment: `named`, or a copy of it with this equipment
/// that is written beside the configuration.
///
/// # Errors
/// The scenario cannot be read, or the copy cannot be written.
pub(crate) fn scenario(
    named: &str,
    equipment: Equipment,
    config: &Path,
) -> anyhow::Result<Option<PathBuf>> {
    let text = scenario_text(named)?;
    let Some(text) = equipment.added_to(&text, named)? else {
        return Ok(None);
    };
    let stem = config.file_stem().unwrap_or_default().to_string_lossy();
    let path = config.with_file_name(format!("{stem}-scenario.toml"));
    write_new(&path, &text)?;
    Ok(Some(path))
}

fn scenario_text(named: &str) -> anyhow::Result<String> {
    if let Some(text) = built_in_text(named) {
        return Ok(text.to_owned());
    }
    let path = Path::new(named);
    if !path.exists() {
        // The error has the names of all scenarios, and the nearest one.
        built_in(named)?;
    }
    bounded_files::read_text(path, bounded_files::TEXT_LIMIT_BYTES)
        .with_context(|| format!("cannot read the scenario {named}"))
}

/// Writes a file that does not exist yet.
///
/// # Errors
/// The file exists, or the operating system refused.
pub(crate) fn write_new(path: &Path, text: &str) -> anyhow::Result<()> {
    if path.exists() {
        bail!(
            "{} exists, and is left as it is: --config FILE writes beside another file, or move it away first",
            path.display()
        );
    }
    let mut file =
        File::create_new(path).with_context(|| format!("cannot write {}", path.display()))?;
    file.write_all(text.as_bytes())?;
    file.sync_all()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const NET_FT_AND_BOX: Equipment = Equipment {
        interface: ForceInterface::Netft,
        protocol: ForceLineFormat::Frames,
        box_beside: true,
        inputs: 2,
    };

    #[test]
    fn equipment_is_added_to_the_named_bench_and_the_rest_of_it_stays() {
        let unknown = built_in_text("bench-unknown").unwrap();
        let gauges = Equipment {
            interface: ForceInterface::Gauges,
            inputs: 9,
            ..NET_FT_AND_BOX
        };
        let text = gauges.added_to(unknown, "bench-unknown").unwrap().unwrap();
        let (new, old) = (
            Scenario::parse(&text, "new").unwrap(),
            Scenario::parse(unknown, "old").unwrap(),
        );
        assert!(gauges.is_in(&new) && !gauges.is_in(&old), "{text}");
        assert_eq!(new.plate, old.plate);
        assert_eq!(
            new.force_sensor.normal_gain, old.force_sensor.normal_gain,
            "{text}"
        );
        // A second time there is nothing to add.
        assert_eq!(gauges.added_to(&text, "new").unwrap(), None);
    }

    #[test]
    fn a_built_in_bench_with_the_equipment_is_taken_by_its_name() {
        let folder = tempfile::tempdir().unwrap();
        let config = folder.path().join("bench.toml");
        let field_box = Equipment {
            interface: ForceInterface::FieldBox,
            box_beside: false,
            ..NET_FT_AND_BOX
        };
        let named = |name, equipment| scenario(name, equipment, &config).unwrap();
        assert_eq!(named("field-box", field_box), None);
        let path = named("net-ft", NET_FT_AND_BOX).unwrap();
        assert_eq!(path, folder.path().join("bench-scenario.toml"));
        // The copy has it, and is not written again.
        assert_eq!(named(path.to_str().unwrap(), NET_FT_AND_BOX), None);
        let error = scenario("nominal", NET_FT_AND_BOX, &config)
            .unwrap_err()
            .to_string();
        assert!(error.contains("is left as it is"), "{error}");
    }

    #[test]
    fn an_unknown_scenario_suggests_the_nearest() {
        let error = scenario("nominl", NET_FT_AND_BOX, Path::new("bench.toml")).unwrap_err();
        assert!(format!("{error:#}").contains("nominal"), "{error:#}");
    }
}
