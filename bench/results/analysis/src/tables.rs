//! Tidy tables as Parquet: one row per instance and method, and one per sample and method. SI units are in the column
//! names, the settings in the files' metadata.
//!
//! The directory of a Parquet file is at its end, so each file is made in memory and written as a whole.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use contact::uncertain::Uncertain;
use estimation::ModelledSeries;
use estimation::trial::SharedFit;
use parquet::basic::{Compression, LogicalType, Repetition, Type as PhysicalType};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use crate::estimate::{InstanceAnalysis, Method, MethodEstimate, PlateOffset};
use crate::findings::{Analysis, RecordingFindings};
use crate::motion::SkinMotion;
use crate::printed_settings::PrintedSettings;
use crate::within_laws::WithinLaws;
use recording::DiskError;
use recording::disk::{self, OnPath};

/// Table with one row per instance and method.
pub const INSTANCES_FILE: &str = "instances.parquet";
/// Table with one row per sample of an instance and method.
pub const SAMPLES_FILE: &str = "samples.parquet";

/// Key of the settings, as JSON, in both tables' metadata.
pub const SETTINGS_KEY: &str = "settings";

/// Reasons why the tables cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum TableError {
    /// The operating system reported an error.
    #[error(transparent)]
    Disk(#[from] DiskError),
    /// The table cannot be encoded.
    #[error("cannot make {}: {reason}", path.display())]
    Parquet {
        /// Path of the file.
        path: PathBuf,
        /// Reason of the failure.
        reason: ParquetError,
    },
}

/// Standard error of an assumed value.
const ASSUMED_STD: f64 = f64::NAN;

/// Column with its values; NaN is an unknown value.
enum Column {
    Flag(&'static str, Vec<bool>),
    Text(&'static str, Vec<ByteArray>),
    Integer(&'static str, Vec<i64>),
    Real(&'static str, Vec<f64>),
}

/// Requires that this program can write tables, which it can, because it was built with the feature `parquet`.
///
/// # Errors
/// Never.
pub fn require_built() -> Result<(), TableError> {
    Ok(())
}

/// Writes both tables into `folder`, which is created if it does not exist; existing tables are replaced.
///
/// # Errors
/// [`TableError`], which names the file.
pub fn write(analysed: &Analysis, folder: &Path) -> Result<(), TableError> {
    std::fs::create_dir_all(folder).with_path("create", folder)?;
    let settings = PrintedSettings::new(analysed);
    for (file, columns) in [
        (INSTANCES_FILE, instances(analysed)),
        (SAMPLES_FILE, samples(analysed)),
    ] {
        let path = folder.join(file);
        let bytes = encode(columns, &settings).map_err(|reason| TableError::Parquet {
            path: path.clone(),
            reason,
        })?;
        disk::replace_file(&path, &bytes)?;
    }
    Ok(())
}

/// Subject of a row: an instance by one method, or by the fit of the whole trial.
struct Row<'a> {
    findings: &'a RecordingFindings,
    number: usize,
    instance: &'a InstanceAnalysis,
    fit: MethodEstimate<'a>,
}

fn rows(analysed: &Analysis) -> Vec<Row<'_>> {
    let recording_rows = |findings| instances_of(findings).collect::<Vec<_>>();
    analysed.findings().flat_map(recording_rows).collect()
}

fn instances_of(findings: &RecordingFindings) -> impl Iterator<Item = Row<'_>> {
    findings
        .instances
        .iter()
        .enumerate()
        .flat_map(move |(index, instance)| {
            instance.estimates().map(move |fit| Row {
                findings,
                number: index + 1,
                instance,
                fit,
            })
        })
}

fn text<'a, 'b: 'a>(
    rows: impl Iterator<Item = &'a Row<'b>>,
    name: &'static str,
    value: fn(&Row<'_>) -> String,
) -> Column {
    let values = rows.map(|row| ByteArray::from(value(row).into_bytes()));
    Column::Text(name, values.collect())
}

/// Returns the columns that identify a row: recording, participant (empty if unknown), trial (0 if unknown), instance and
/// exploration from 1, direction, method.
fn keys<'a>(rows: impl Iterator<Item = &'a Row<'a>> + Clone) -> Vec<Column> {
    let text = |name, value| text(rows.clone(), name, value);
    let integer =
        |name, value: fn(&Row<'_>) -> i64| Column::Integer(name, rows.clone().map(value).collect());
    vec![
        text("recording", |row| row.findings.path.display().to_string()),
        text("participant", |row| {
            row.findings.participant().unwrap_or_default().to_owned()
        }),
        integer("trial", |row| {
            let trial = row.findings.manifest.trial.as_ref();
            trial.map_or(0, |trial| i64::from(trial.number))
        }),
        integer("instance", |row| row.number as i64),
        integer("exploration", |row| row.instance.exploration as i64 + 1),
        text("direction", |row| {
            match row.instance.direction {
                protocols::Direction::LeftToRight => "left_to_right",
                protocols::Direction::RightToLeft => "right_to_left",
            }
            .to_owned()
        }),
        text("method", |row| row.fit.method.name().to_owned()),
    ]
}

fn instances(analysed: &Analysis) -> Vec<Column> {
    let rows = rows(analysed);
    let real =
        |name, value: fn(&Row<'_>) -> f64| Column::Real(name, rows.iter().map(value).collect());
    let mut columns = keys(rows.iter());
    columns.extend([
        real("start_s", |r| r.instance.start_s),
        real("end_s", |r| r.instance.end_s),
        real("normal_n", |r| r.instance.normal_n),
        real("measured_delta_mu", |r| r.instance.delta_mu),
        real("sigma_t_m", |r| r.estimate().sigma_t_m),
        real("sigma_t_std_m", |r| r.estimate().sigma_t_std_m),
        real("re_z_t_n_s_per_m", |r| r.estimate().z_t_n_s_per_m.re),
        real("re_z_t_std_n_s_per_m", |r| {
            r.estimate().z_t_std_n_s_per_m.re
        }),
        real("im_z_t_n_s_per_m", |r| r.estimate().z_t_n_s_per_m.im),
        real("im_z_t_std_n_s_per_m", |r| {
            r.estimate().z_t_std_n_s_per_m.im
        }),
        real("tau_s", |r| {
            r.estimate().tau_s.map_or(f64::NAN, |tau| tau.0)
        }),
        real("tau_std_s", |r| {
            r.estimate().tau_s.map_or(f64::NAN, |tau| tau.1)
        }),
        real("mu0", |r| r.estimate().mu0),
        real("mu0_std", |r| r.estimate().mu0_std),
        real("r2_impedance", |r| r.estimate().agreement.r2_impedance),
        real("rms_mu", |r| r.estimate().agreement.rms_mu),
        real("spearman_mu", |r| {
            r.estimate().spearman_mu.map_or(f64::NAN, |s| s.rho)
        }),
        real("carrier_hz", |r| r.findings.manifest.carrier_hz),
        real("re_z_p_n_s_per_m", |r| r.estimate().z_p_n_s_per_m.re),
        real("im_z_p_n_s_per_m", |r| r.estimate().z_p_n_s_per_m.im),
        real("re_rigid_z_t_n_s_per_m", |r| {
            r.estimate().rigid_z_t_n_s_per_m.re
        }),
        real("im_rigid_z_t_n_s_per_m", |r| {
            r.estimate().rigid_z_t_n_s_per_m.im
        }),
        real("at_rest_up_to_amplitude_m", |r| {
            let at_rest = r.instance.paper.rest;
            at_rest.map_or(f64::NAN, |rest| rest.up_to_amplitude_m)
        }),
        real("averaged_sigma_t_m", |r| r.estimate().averaged.sigma_t_m),
        real("delta_abs_z_m_n_s_per_m", |r| {
            r.estimate().deltas.abs_z_m_n_s_per_m
        }),
        real("delta_re_z_m_n_s_per_m", |r| {
            r.estimate().deltas.re_z_m_n_s_per_m
        }),
        real("delta_abs_im_z_m_n_s_per_m", |r| {
            r.estimate().deltas.abs_im_z_m_n_s_per_m
        }),
        real("delta_reaction_force_n", |r| {
            r.estimate().deltas.reaction_force_n
        }),
        real("delta_squeeze_n", |r| r.estimate().deltas.squeeze_n),
        real("delta_gap_m", |r| r.estimate().deltas.gap_m),
        real("delta_mu", |r| r.estimate().deltas.mu),
        real("amplitude_ratio", |r| r.mean_amplitude_ratio()),
        real("contact_area_m2", |r| r.estimate().skin.contact_area_m2),
        real("q0_rad_per_m", |r| r.estimate().skin.q0_rad_per_m),
        real("loss_factor", |r| r.estimate().skin.loss_factor),
        real("ambient_pressure_pa", |r| {
            r.estimate().skin.ambient_pressure_pa
        }),
        real("re_plate_offset_n_s_per_m", |r| {
            r.offset(|offset| offset.n_s_per_m.re)
        }),
        real("im_plate_offset_n_s_per_m", |r| {
            r.offset(|offset| offset.n_s_per_m.im)
        }),
        real("re_plate_offset_std_n_s_per_m", |r| {
            r.offset(|offset| offset.std_n_s_per_m.re)
        }),
        real("im_plate_offset_std_n_s_per_m", |r| {
            r.offset(|offset| offset.std_n_s_per_m.im)
        }),
        real("resonance_shift_hz", |r| {
            r.offset(|offset| offset.resonance_shift_hz)
        }),
        real("friction_floor", |r| {
            r.friction(|shared| shared.friction_floor)
        }),
        real("lateral_lag_s", |r| {
            r.friction(|shared| shared.lateral_lag_s)
        }),
        real("resonance_shift_std_hz", |r| {
            r.offset(|offset| offset.resonance_shift_std_hz)
        }),
    ]);
    columns.extend(shared_columns(&rows));
    columns.extend(columns_within_laws(&rows));
    columns
}

/// Returns the remaining columns of the whole recording's fit: standard errors of the fitted values, the extensions of the
/// published laws, and whether the model holds.
fn shared_columns(rows: &[Row<'_>]) -> Vec<Column> {
    let real =
        |name, value: fn(&Row<'_>) -> f64| Column::Real(name, rows.iter().map(value).collect());
    vec![
        real("contact_area_ln_std", |r| {
            r.shared(ASSUMED_STD, |shared| shared.contact_area_m2.ln_std)
        }),
        real("q0_ln_std", |r| {
            r.shared(ASSUMED_STD, |shared| shared.q0_rad_per_m.ln_std)
        }),
        real("loss_factor_ln_std", |r| {
            r.shared(ASSUMED_STD, |shared| shared.loss_factor.ln_std)
        }),
        real("shared_tau_s", |r| {
            r.shared(f64::NAN, |shared| shared.tau_s.value)
        }),
        real("shared_tau_ln_std", |r| {
            r.shared(ASSUMED_STD, |shared| shared.tau_s.ln_std)
        }),
        real("area_force_exponent", |r| {
            r.shared(0.0, |shared| shared.area_exponent.value)
        }),
        real("area_force_exponent_std", |r| {
            r.shared(ASSUMED_STD, |shared| shared.area_exponent.std)
        }),
        real("film_mean_s", |r| {
            r.shared(0.0, |shared| shared.film_mean_s)
        }),
        real("film_mean_ln_std", |_| ASSUMED_STD),
        real("lag_gap_exponent", |r| {
            r.shared(0.0, |shared| shared.lag_exponent.value)
        }),
        real("lag_gap_exponent_std", |r| {
            r.shared(ASSUMED_STD, |shared| shared.lag_exponent.std)
        }),
        real("friction_floor_std", |r| {
            r.shared(ASSUMED_STD, |shared| {
                shared.friction_floor.map_or(f64::NAN, |floor| floor.std)
            })
        }),
        real("lateral_lag_std_s", |r| {
            r.shared(ASSUMED_STD, |shared| {
                shared.lateral_lag_s.map_or(f64::NAN, |lag| lag.std)
            })
        }),
        text(rows.iter(), "verdict", |r| r.estimate().verdict.to_string()),
        Column::Flag(
            "model_misfit",
            rows.iter().map(|row| !row.misfit().is_empty()).collect(),
        ),
        text(rows.iter(), "misfit", |r| r.misfit().join("; ")),
    ]
}

/// Returns the estimates of `trial` with the laws as published taken as true; NaN where these do not hold.
fn columns_within_laws(rows: &[Row<'_>]) -> Vec<Column> {
    let instance = |name, value: fn(&WithinLaws) -> f64| {
        let value_of = |row: &Row<'_>| row.instance_within_laws().map_or(f64::NAN, value);
        Column::Real(name, rows.iter().map(value_of).collect())
    };
    let shared = |name, value: fn(&SharedFit) -> f64| {
        let value_of = |row: &Row<'_>| row.shared_within_laws().map_or(f64::NAN, value);
        Column::Real(name, rows.iter().map(value_of).collect())
    };
    vec![
        instance("sigma_t_within_laws_m", |fit| fit.sigma_t_m.value),
        instance("sigma_t_within_laws_std_m", |fit| {
            fit.sigma_t_m.value * fit.sigma_t_m.ln_std
        }),
        instance("re_z_t_within_laws_n_s_per_m", |fit| fit.z_t_n_s_per_m.re),
        instance("re_z_t_within_laws_std_n_s_per_m", |fit| {
            fit.z_t_std_n_s_per_m.re
        }),
        instance("im_z_t_within_laws_n_s_per_m", |fit| fit.z_t_n_s_per_m.im),
        instance("im_z_t_within_laws_std_n_s_per_m", |fit| {
            fit.z_t_std_n_s_per_m.im
        }),
        instance("mu0_within_laws", |fit| fit.mu0.value),
        instance("mu0_within_laws_std", |fit| fit.mu0.std),
        instance("resonance_shift_within_laws_hz", |fit| {
            fit.resonance_shift_hz.value
        }),
        instance("resonance_shift_within_laws_std_hz", |fit| {
            fit.resonance_shift_hz.std
        }),
        shared("contact_area_within_laws_m2", |fit| {
            fit.contact_area_m2.value
        }),
        shared("contact_area_within_laws_ln_std", |fit| {
            fit.contact_area_m2.ln_std
        }),
        shared("q0_within_laws_rad_per_m", |fit| fit.q0_rad_per_m.value),
        shared("q0_within_laws_ln_std", |fit| fit.q0_rad_per_m.ln_std),
        shared("loss_factor_within_laws", |fit| fit.loss_factor.value),
        shared("loss_factor_within_laws_ln_std", |fit| {
            fit.loss_factor.ln_std
        }),
        shared("shared_tau_within_laws_s", |fit| fit.tau_s.value),
        shared("shared_tau_within_laws_ln_std", |fit| fit.tau_s.ln_std),
        shared("area_force_exponent_within_laws", |fit| {
            fit.area_exponent.value
        }),
        shared("area_force_exponent_within_laws_std", |fit| {
            fit.area_exponent.std
        }),
        shared("lag_gap_exponent_within_laws", |fit| fit.lag_exponent.value),
        shared("lag_gap_exponent_within_laws_std", |fit| {
            fit.lag_exponent.std
        }),
        shared("friction_floor_within_laws", |fit| {
            fit.friction_floor.map_or(f64::NAN, |floor| floor.value)
        }),
        shared("friction_floor_within_laws_std", |fit| {
            fit.friction_floor.map_or(f64::NAN, |floor| floor.std)
        }),
        shared("lateral_lag_within_laws_s", |fit| {
            fit.lateral_lag_s.map_or(f64::NAN, |lag| lag.value)
        }),
        shared("lateral_lag_within_laws_std_s", |fit| {
            fit.lateral_lag_s.map_or(f64::NAN, |lag| lag.std)
        }),
    ]
}

fn samples(analysed: &Analysis) -> Vec<Column> {
    let rows = rows(analysed);
    let row_samples = || {
        let indices = |row| (0..Row::len(row)).map(move |k| (row, k));
        rows.iter().flat_map(indices)
    };
    let real = |name, value: fn(&Row<'_>, usize) -> f64| {
        Column::Real(name, row_samples().map(|(row, k)| value(row, k)).collect())
    };
    let mut columns = keys(row_samples().map(|(row, _)| row));
    columns.extend([
        real("time_s", |r, k| r.instance.samples.time_s()[k]),
        real("amplitude_m", |r, k| {
            r.instance.samples.amplitude_m(r.fit.method)[k]
        }),
        real("normal_n", |r, k| r.instance.samples.normal_n()[k]),
        real("finger_force_n", |r, k| {
            r.instance.samples.finger_force_n()[k]
        }),
        real("measured_mu", |r, k| r.instance.samples.mu()[k]),
        real("re_z_m_n_s_per_m", |r, k| r.fit.z_m()[k].re),
        real("im_z_m_n_s_per_m", |r, k| r.fit.z_m()[k].im),
        real("re_z_m_model_n_s_per_m", |r, k| {
            r.estimate().series.z_m_model_n_s_per_m[k].re
        }),
        real("im_z_m_model_n_s_per_m", |r, k| {
            r.estimate().series.z_m_model_n_s_per_m[k].im
        }),
        real("k_c_n_per_m", |r, k| r.estimate().series.k_c_n_per_m[k]),
        real("k_c_std_n_per_m", |r, k| {
            r.estimate().series.k_c_std_n_per_m[k]
        }),
        real("gap_m", |r, k| r.estimate().series.gap_m[k]),
        real("gap_std_m", |r, k| r.estimate().series.gap_std_m[k]),
        real("mu", |r, k| r.estimate().series.mu[k]),
        real("mu_std", |r, k| r.estimate().series.mu_std[k]),
        real("reaction_force_n", |r, k| {
            r.motion().reaction_force_n[k].norm()
        }),
        real("reaction_force_phase_rad", |r, k| {
            r.motion().reaction_force_n[k].arg()
        }),
        real("contact_force_n", |r, k| {
            r.motion().contact_force_n[k].norm()
        }),
        real("contact_force_phase_rad", |r, k| {
            r.motion().contact_force_n[k].arg()
        }),
        real("skin_per_plate", |r, k| r.motion().skin_per_plate[k].norm()),
        real("skin_per_plate_phase_rad", |r, k| {
            r.motion().skin_per_plate[k].arg()
        }),
        real("plate_power_w", |r, k| r.motion().plate_power_w[k]),
        real("skin_power_w", |r, k| r.motion().skin_power_w[k]),
        real("film_force_n", |r, k| r.estimate().film_force_n[k]),
        real("re_z_m_averaged_n_s_per_m", |r, k| {
            r.averaged_value(|model| model.z_m_n_s_per_m[k].re)
        }),
        real("im_z_m_averaged_n_s_per_m", |r, k| {
            r.averaged_value(|model| model.z_m_n_s_per_m[k].im)
        }),
        real("k_c_averaged_n_per_m", |r, k| {
            r.averaged_value(|model| model.k_c_n_per_m[k])
        }),
        real("gap_averaged_m", |r, k| {
            r.averaged_value(|model| model.gap_m[k])
        }),
        real("mu_averaged", |r, k| r.averaged_value(|model| model.mu[k])),
        real("amplitude_ratio", |r, k| {
            r.instance.samples.amplitude_ratio(r.fit.method, k)
        }),
    ]);
    columns
}

impl Row<'_> {
    fn estimate(&self) -> &crate::estimate::InstanceEstimate {
        self.fit.estimate
    }

    fn motion(&self) -> &SkinMotion {
        &self.estimate().motion
    }

    /// Returns a value of the model with the participant's average σ_t; NaN if it allows no such contact.
    fn averaged_value(&self, value: impl Fn(&ModelledSeries) -> f64) -> f64 {
        let series = &self.estimate().averaged.series;
        series.as_ref().map_or(f64::NAN, value)
    }

    /// Returns a number of the plate's offset; 0 if none was fitted.
    fn offset(&self, value: impl Fn(&PlateOffset) -> f64) -> f64 {
        self.estimate().plate_offset.as_ref().map_or(0.0, value)
    }

    /// Returns the fit of the whole recording, for a row by `trial`.
    fn trial(&self) -> Option<&SharedFit> {
        let trial = self.findings.trial.as_ref();
        trial.filter(|_| self.fit.method == Method::Trial)
    }

    /// Returns the whole recording's fit by the published laws where these hold, for a row by `trial`.
    fn shared_within_laws(&self) -> Option<&SharedFit> {
        self.trial()?;
        self.findings.fit_within_laws()
    }

    /// Returns the instance's estimates by the published laws where these hold, for a row by `trial`.
    fn instance_within_laws(&self) -> Option<&WithinLaws> {
        self.trial()?;
        self.instance.within_laws.as_ref()
    }

    /// Returns a number of the whole recording's fit, or `fallback` for the other methods.
    fn shared(&self, fallback: f64, value: impl Fn(&SharedFit) -> f64) -> f64 {
        self.trial().map_or(fallback, value)
    }

    /// Returns a number of the recording's friction; 0 for the other methods.
    fn friction(&self, value: impl Fn(&SharedFit) -> Option<Uncertain>) -> f64 {
        self.shared(0.0, |shared| {
            value(shared).map_or(f64::NAN, |friction| friction.value)
        })
    }

    /// Returns the signs of misfit: of the instance, or by `trial` of the recording.
    fn misfit(&self) -> Vec<String> {
        match self.trial() {
            Some(shared) => shared.misfit.iter().map(ToString::to_string).collect(),
            None => self
                .estimate()
                .misfit
                .iter()
                .map(ToString::to_string)
                .collect(),
        }
    }

    fn mean_amplitude_ratio(&self) -> f64 {
        let ratio = |k| self.instance.samples.amplitude_ratio(self.fit.method, k);
        (0..self.len()).map(ratio).sum::<f64>() / self.len() as f64
    }

    fn len(&self) -> usize {
        self.instance.samples.time_s().len()
    }
}

fn encode(columns: Vec<Column>, settings: &PrintedSettings) -> Result<Vec<u8>, ParquetError> {
    let fields = columns.iter().map(|column| {
        let (name, physical_type, logical_type) = match column {
            Column::Flag(name, _) => (name, PhysicalType::BOOLEAN, None),
            Column::Text(name, _) => (name, PhysicalType::BYTE_ARRAY, Some(LogicalType::String)),
            Column::Integer(name, _) => (name, PhysicalType::INT64, None),
            Column::Real(name, _) => (name, PhysicalType::DOUBLE, None),
        };
        Type::primitive_type_builder(name, physical_type)
            .with_repetition(Repetition::REQUIRED)
            .with_logical_type(logical_type)
            .build()
            .map(Arc::new)
    });
    let schema = Type::group_type_builder("schema")
        .with_fields(fields.collect::<Result<_, _>>()?)
        .build()?;
    let settings_json =
        serde_json::to_string(settings).map_err(|error| ParquetError::External(Box::new(error)))?;
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_key_value_metadata(Some(vec![KeyValue::new(
            SETTINGS_KEY.to_owned(),
            settings_json,
        )]))
        .build();
    let mut writer = SerializedFileWriter::new(Vec::new(), Arc::new(schema), Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    for column in columns {
        let Some(mut column_writer) = group.next_column()? else {
            break;
        };
        match column {
            Column::Flag(_, values) => column_writer
                .typed::<BoolType>()
                .write_batch(&values, None, None)?,
            Column::Text(_, values) => column_writer
                .typed::<ByteArrayType>()
                .write_batch(&values, None, None)?,
            Column::Integer(_, values) => column_writer
                .typed::<Int64Type>()
                .write_batch(&values, None, None)?,
            Column::Real(_, values) => column_writer
                .typed::<DoubleType>()
                .write_batch(&values, None, None)?,
        };
        column_writer.close()?;
    }
    group.close()?;
    writer.into_inner()
}
