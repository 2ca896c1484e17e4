//! Results of an analysis, read as `docs/RECORDING.md` describes them. Keys that a version does not write are absent.

use std::collections::HashMap;
use std::fmt;

use serde::Deserialize;
use serde::de::{Deserializer, MapAccess, Visitor};
use serde_json::{Map, Value};

/// Lower and upper end.
pub(crate) type Interval = [Option<f64>; 2];

#[derive(Debug, Deserialize)]
pub(crate) struct Results {
    #[serde(default)]
    pub(crate) settings: Map<String, Value>,
    pub(crate) recordings: Vec<Recording>,
    pub(crate) skin: Option<Skin>,
    #[serde(default, deserialize_with = "in_order")]
    pub(crate) statistics: Vec<(String, Row)>,
    #[serde(default)]
    pub(crate) excluded: Vec<Excluded>,
    /// Exclusions that were overridden: their recordings were analysed.
    #[serde(default)]
    pub(crate) exclusions_overridden: Vec<Excluded>,
    pub(crate) attempts: Option<Attempts>,
}

/// Numbers of attempts by standing.
#[derive(Debug, Deserialize)]
pub(crate) struct Attempts {
    pub(crate) accepted: usize,
    pub(crate) analysed: usize,
    pub(crate) not_accepted: usize,
    #[serde(default)]
    pub(crate) left_out: Vec<LeftOutAttempt>,
    #[serde(default)]
    pub(crate) unread_logs: Vec<String>,
}

/// Attempt that was not analysed.
#[derive(Debug, Deserialize)]
pub(crate) struct LeftOutAttempt {
    pub(crate) path: String,
    pub(crate) standing: Option<String>,
    pub(crate) because: String,
}

impl LeftOutAttempt {
    /// Returns whether an accepted trial is missing from the analysis.
    pub(crate) fn is_missed(&self) -> bool {
        self.standing
            .as_deref()
            .is_none_or(|standing| standing == "accepted")
    }

    /// Returns the last names of the folder's path.
    pub(crate) fn name(&self) -> String {
        let names: Vec<&str> = self.path.rsplit('/').take(3).collect();
        names.into_iter().rev().collect::<Vec<_>>().join("/")
    }
}

#[derive(Debug, Deserialize)]
pub(crate) struct Recording {
    #[serde(default)]
    pub(crate) path: String,
    pub(crate) participant: Option<String>,
    #[serde(default)]
    pub(crate) plate_profile: bool,
    pub(crate) pickup_undone: Option<PickupUndone>,
    #[serde(default)]
    pub(crate) z_p_n_s_per_m: ZpByMethod,
    #[serde(default)]
    pub(crate) instances: Vec<Instance>,
    pub(crate) trial: Option<Trial>,
    #[serde(default)]
    pub(crate) model_check: Vec<Band>,
    #[serde(default)]
    pub(crate) rejected: Vec<Rejected>,
    #[serde(default)]
    pub(crate) warnings: Vec<String>,
}

#[derive(Debug, Deserialize)]
pub(crate) struct PickupUndone {
    pub(crate) phase_rad: Option<f64>,
    pub(crate) delay_s: Option<f64>,
}

#[derive(Debug, Default, Deserialize)]
pub(crate) struct ZpByMethod {
    pub(crate) paper: Option<Interval>,
    pub(crate) dynamic: Option<Interval>,
}

#[derive(Debug, Deserialize)]
pub(crate) struct Instance {
    pub(crate) start_s: f64,
    pub(crate) end_s: f64,
    pub(crate) direction: String,
    pub(crate) normal_n: Option<f64>,
    pub(crate) delta_mu: Option<f64>,
    pub(crate) paper: Option<Estimate>,
    pub(crate) dynamic: Option<Estimate>,
    pub(crate) trial: Option<Estimate>,
}

impl Instance {
    /// Returns the available estimates, by the names of their methods.
    pub(crate) fn estimates(&self) -> impl Iterator<Item = (&'static str, &Estimate)> {
        let methods = [
            ("paper", &self.paper),
            ("dynamic", &self.dynamic),
            ("trial", &self.trial),
        ];
        methods
            .into_iter()
            .filter_map(|(name, estimate)| Some((name, estimate.as_ref()?)))
    }
}

#[derive(Debug, Deserialize)]
pub(crate) struct Estimate {
    pub(crate) sigma_t_m: Option<f64>,
    pub(crate) z_t_n_s_per_m: Option<Interval>,
    pub(crate) tau_s: Option<f64>,
    pub(crate) resonance_shift_hz: Option<f64>,
    pub(crate) mu0: Option<f64>,
    pub(crate) r2_impedance: Option<f64>,
    pub(crate) rms_mu: Option<f64>,
    #[serde(default)]
    pub(crate) verdict: String,
    pub(crate) std: Option<Std>,
    pub(crate) interval95: Option<InstanceIntervals>,
    pub(crate) sensitivity: Option<Sensitivity>,
}

#[derive(Debug, Deserialize)]
pub(crate) struct Std {
    pub(crate) sigma_t_m: Option<f64>,
    pub(crate) z_t_n_s_per_m: Option<Interval>,
    pub(crate) tau_s: Option<f64>,
    pub(crate) mu0: Option<f64>,
    pub(crate) resonance_shift_hz: Option<f64>,
}

#[derive(Debug, Deserialize)]
pub(crate) struct InstanceIntervals {
    pub(crate) sigma_t_m: Option<Interval>,
    pub(crate) z_t_re_n_s_per_m: Option<Interval>,
    pub(crate) z_t_im_n_s_per_m: Option<Interval>,
    pub(crate) mu0: Option<Interval>,
    pub(crate) resonance_shift_hz: Option<Interval>,
}

#[derive(Debug, Deserialize)]
pub(crate) struct Sensitivity {
    pub(crate) sigma_q0_rad_per_m: SensitivityRow,
    pub(crate) young_modulus_pa: SensitivityRow,
    pub(crate) poisson_ratio: SensitivityRow,
    pub(crate) contact_area_m2: SensitivityRow,
}

#[derive(Debug, Deserialize)]
pub(crate) struct SensitivityRow {
    pub(crate) ln_sigma_t: Option<f64>,
    pub(crate) ln_abs_z_t: Option<f64>,
}

/// Parameters that the instances of a recording share.
#[derive(Debug, Deserialize)]
pub(crate) struct Trial {
    #[serde(default)]
    pub(crate) verdict: String,
    pub(crate) n_instances: Option<u64>,
    /// Whether the model does not fit the recording; absent if this was not tested.
    pub(crate) model_misfit: Option<Value>,
    /// Null if the model does not fit.
    interval95: Option<Map<String, Value>>,
    /// Parameters by name.
    #[serde(flatten)]
    pub(crate) parameters: Map<String, Value>,
}

impl Trial {
    /// Returns a parameter and its interval.
    pub(crate) fn parameter(&self, name: &str) -> (Option<f64>, Option<Interval>) {
        let intervals = self.interval95.as_ref();
        let ends = intervals.and_then(|intervals| intervals.get(name)?.as_array());
        let interval = ends.and_then(|ends| match ends.as_slice() {
            [low, high] => Some([low.as_f64(), high.as_f64()]),
            _ => None,
        });
        (self.parameters.get(name).and_then(Value::as_f64), interval)
    }

    /// Returns the signs of misfit, in words.
    pub(crate) fn signs(&self) -> impl Iterator<Item = &str> {
        let signs = self.parameters.get("misfit").and_then(Value::as_array);
        signs.into_iter().flatten().filter_map(Value::as_str)
    }

    /// Returns whether the model does not fit; `None` if this was not tested.
    pub(crate) fn misfit(&self) -> Option<bool> {
        match self.model_misfit.as_ref()? {
            Value::Bool(misfit) => Some(*misfit),
            Value::Object(evidence) => evidence.get("misfit").and_then(Value::as_bool),
            _ => None,
        }
    }
}

/// Skin of the participants and of the study; parameters by name.
#[derive(Debug, Deserialize)]
pub(crate) struct Skin {
    #[serde(default)]
    pub(crate) participants: Vec<Person>,
    #[serde(default)]
    pub(crate) study: HashMap<String, StudyParameter>,
    #[serde(default)]
    pub(crate) left_out: Vec<Value>,
}

#[derive(Debug, Deserialize)]
pub(crate) struct Person {
    pub(crate) participant: String,
    #[serde(default)]
    pub(crate) trials: Vec<PooledTrial>,
    #[serde(default)]
    pub(crate) n_left_out: u64,
    #[serde(flatten)]
    parameters: Map<String, Value>,
}

impl Person {
    /// Returns a parameter; `None` if no trial constrains it.
    pub(crate) fn parameter(&self, name: &str) -> Option<PersonParameter> {
        PersonParameter::deserialize(self.parameters.get(name)?).ok()
    }
}

/// Recording of a participant.
#[derive(Debug, Deserialize)]
pub(crate) struct PooledTrial {
    pub(crate) path: String,
    #[serde(flatten)]
    parameters: Map<String, Value>,
}

impl PooledTrial {
    /// Returns the shrunken value of a parameter.
    pub(crate) fn shrunken(&self, name: &str) -> Option<Ranged> {
        Ranged::deserialize(self.parameters.get(name)?.get("shrunken")?).ok()
    }
}

#[derive(Debug, Deserialize)]
pub(crate) struct PersonParameter {
    #[serde(flatten)]
    pub(crate) mean: Ranged,
    pub(crate) shrunken: Option<Ranged>,
}

#[derive(Debug, Deserialize)]
pub(crate) struct StudyParameter {
    pub(crate) mean: Option<Ranged>,
    pub(crate) between_participants_ln_std: Option<f64>,
    pub(crate) between_participants_ln_std_interval95: Option<Interval>,
    pub(crate) between_trials_ln_std: Option<f64>,
    pub(crate) shared_error_part: Option<f64>,
}

#[derive(Debug, Deserialize)]
pub(crate) struct Ranged {
    pub(crate) value: Option<f64>,
    pub(crate) interval95: Option<Interval>,
}

#[derive(Debug, Deserialize)]
pub(crate) struct Band {
    pub(crate) amplitude_from_m: Option<f64>,
    pub(crate) amplitude_to_m: Option<f64>,
    pub(crate) n: u64,
    pub(crate) force_relative_difference_median: Option<f64>,
    pub(crate) force_relative_difference_p90: Option<f64>,
}

#[derive(Debug, Deserialize)]
pub(crate) struct Rejected {
    pub(crate) start_s: f64,
    pub(crate) end_s: f64,
    pub(crate) reason: String,
}

#[derive(Debug, Deserialize)]
pub(crate) struct Excluded {
    pub(crate) participant: String,
    pub(crate) session: String,
    pub(crate) trial: String,
    pub(crate) reason: String,
    pub(crate) by: String,
    pub(crate) date: Option<String>,
    #[serde(default)]
    pub(crate) recordings: Vec<String>,
}

/// Published statistic, next to the value of these data.
#[derive(Debug, Deserialize)]
pub(crate) struct Row {
    pub(crate) meaning: String,
    pub(crate) published: String,
    pub(crate) paper: Option<MethodStatistic>,
    pub(crate) dynamic: Option<MethodStatistic>,
    pub(crate) trial: Option<MethodStatistic>,
}

#[derive(Debug, Deserialize)]
pub(crate) struct MethodStatistic {
    #[serde(flatten)]
    pub(crate) main: Statistic,
    #[serde(default)]
    pub(crate) also: Vec<Statistic>,
}

#[derive(Debug, Deserialize)]
pub(crate) struct Statistic {
    pub(crate) value: Option<f64>,
    pub(crate) std: Option<f64>,
    pub(crate) p: Option<f64>,
    pub(crate) clustered: Option<Clustered>,
    pub(crate) n: u64,
    pub(crate) over: String,
}

#[derive(Debug, Deserialize)]
pub(crate) struct Clustered {
    pub(crate) p: Option<f64>,
    pub(crate) people: u64,
}

/// Deserialises a map as a list, in the order of the file.
fn in_order<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<(String, Row)>, D::Error> {
    struct RowsVisitor;
    impl<'de> Visitor<'de> for RowsVisitor {
        type Value = Vec<(String, Row)>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("statistics by name")
        }

        fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
            let mut rows = Vec::new();
            while let Some(row) = map.next_entry()? {
                rows.push(row);
            }
            Ok(rows)
        }
    }
    deserializer.deserialize_map(RowsVisitor)
}
