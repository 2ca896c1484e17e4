//! Options of `friction-bench init`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::rig::Rig;

/// Options of `init`.
#[derive(Debug, Args)]
pub struct InitOptions {
    /// File to write; an existing file is not overwritten.
    #[arg(long, value_name = "FILE", default_value = "bench.toml")]
    pub config: PathBuf,
    /// Hardware of the bench.
    #[arg(long, value_enum)]
    pub rig: Option<Rig>,
    /// Sound card that drives the plate and reads the pickup, by id or name.
    #[arg(long, value_name = "NAME")]
    pub card: Option<String>,
    /// Serial port of the force sensor.
    #[arg(long, value_name = "PORT")]
    pub force_port: Option<PathBuf>,
    /// Format of the force sensor's data on the serial port.
    #[arg(long, value_enum)]
    pub force_line: Option<ForceLine>,
    /// Network address of an ATI Net F/T.
    #[arg(long, value_name = "ADDRESS", conflicts_with = "cal_file")]
    pub net_ft: Option<String>,
    /// Maker's calibration file of a sensor with gauges on inputs of the card.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["force_port", "force_line"])]
    pub cal_file: Option<PathBuf>,
    /// Serial port of the field box.
    #[arg(long, value_name = "PORT")]
    pub box_port: Option<PathBuf>,
    /// Name of the plate; a calibration is valid only for this plate.
    #[arg(long, value_name = "NAME")]
    pub plate: Option<String>,
    /// Inspect simulated hardware instead, as described by a built-in scenario or a scenario file.
    #[arg(long, value_name = "SCENARIO", num_args = 0..=1, default_missing_value = "nominal", help_heading = "Simulation")]
    pub mock: Option<String>,
}

impl InitOptions {
    /// Returns the first given option that does not apply to `rig`, if any.
    pub fn unfit_option(&self, rig: Rig) -> Option<&'static str> {
        let six_axis = rig == Rig::SixAxis;
        [
            (
                "--force-port",
                self.force_port.is_some(),
                rig.has_force_line(),
            ),
            (
                "--force-line",
                self.force_line.is_some(),
                rig.has_force_line(),
            ),
            ("--net-ft", self.net_ft.is_some(), six_axis),
            (
                "--cal-file",
                self.cal_file.is_some(),
                six_axis || rig == Rig::Published,
            ),
            ("--box-port", self.box_port.is_some(), rig.has_field_box()),
        ]
        .into_iter()
        .find_map(|(option, is_given, fits)| (is_given && !fits).then_some(option))
    }
}

/// Format of a force sensor's data on a serial line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ForceLine {
    /// Binary frames with a sequence number and a checksum.
    Frames,
    /// Lines of text, as printed by a microcontroller.
    Lines,
}

impl ForceLine {
    /// Returns its name in `bench.toml`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Frames => "frames",
            Self::Lines => "lines",
        }
    }
}
