//! Roles of vectors in a recording: forces, the finger's place, envelopes.

use crate::carrier::Carrier;
use crate::names::Role;
use crate::nature::Nature;
use crate::pair::drive_pair;
use crate::polar::{self, PhaseUnit, phase_unit};
use crate::portrait::{FilePortrait, VectorPortrait};
use crate::slow::{Slow, Steps};
use crate::units::UnitMeaning;

/// A vector with a role, and the reason.
#[derive(Debug, Clone)]
pub(crate) struct Chosen<'a> {
    /// Index of the file among those given.
    pub file: usize,
    pub vector: &'a VectorPortrait,
    pub reason: String,
    pub is_sure: bool,
}

/// Two vectors with the parts of complex envelopes, or one complex one.
#[derive(Debug, Clone)]
pub(crate) enum EnvelopeArrays<'a> {
    Complex(&'a VectorPortrait),
    Parts(&'a VectorPortrait, &'a VectorPortrait),
    Polar(&'a VectorPortrait, &'a VectorPortrait),
}

impl<'a> EnvelopeArrays<'a> {
    /// Returns the first vector.
    pub fn first(&self) -> &'a VectorPortrait {
        match self {
            Self::Complex(vector) | Self::Parts(vector, _) | Self::Polar(vector, _) => vector,
        }
    }
}

/// Envelopes of drive and pickup.
#[derive(Debug, Clone)]
pub(crate) struct EnvelopePair<'a> {
    pub file: usize,
    pub drive: EnvelopeArrays<'a>,
    pub pickup: EnvelopeArrays<'a>,
    /// Unit of the phases, if there are any.
    pub phases: Option<PhaseUnit>,
    pub reason: String,
    pub is_sure: bool,
}

/// Vectors of a recording by their roles.
#[derive(Debug, Clone, Default)]
pub(crate) struct Roles<'a> {
    pub signals: Option<(Chosen<'a>, Chosen<'a>)>,
    pub envelopes: Option<EnvelopePair<'a>>,
    pub normal: Option<Chosen<'a>>,
    pub lateral: Option<Chosen<'a>>,
    pub position: Option<Chosen<'a>>,
    pub velocity: Option<Chosen<'a>>,
}

impl Roles<'_> {
    /// Returns whether each stream that others have is there.
    pub fn has_streams_of(&self, others: &Roles<'_>) -> bool {
        let streams = |roles: &Roles<'_>| {
            [
                roles.signals.is_some(),
                roles.envelopes.is_some(),
                roles.normal.is_some(),
                roles.lateral.is_some(),
                roles.position.is_some() || roles.velocity.is_some(),
            ]
        };
        let mut pairs = streams(self).into_iter().zip(streams(others));
        pairs.all(|(is_here, is_there)| is_here || !is_there)
    }
}

/// Fewest values of a stream; a row of scales has less.
const FEWEST: u64 = 32;

/// Finds the roles in files that together make a recording.
pub(crate) fn roles(files: &[FilePortrait]) -> Roles<'_> {
    let all: Vec<(usize, &VectorPortrait)> = files
        .iter()
        .enumerate()
        .flat_map(|(index, file)| file.vectors.iter().map(move |vector| (index, vector)))
        .filter(|(_, vector)| vector.extremes.is_some() && vector.length >= FEWEST)
        .collect();
    let signals = signals(&all);
    let envelopes = if signals.is_some() {
        None
    } else {
        envelopes(&all)
    };
    let used = |vector: &VectorPortrait| {
        let names = envelopes
            .iter()
            .flat_map(|pair| [&pair.drive, &pair.pickup]);
        names.into_iter().any(|arrays| match arrays {
            EnvelopeArrays::Complex(a) => std::ptr::eq(*a, vector),
            EnvelopeArrays::Parts(a, b) | EnvelopeArrays::Polar(a, b) => {
                std::ptr::eq(*a, vector) || std::ptr::eq(*b, vector)
            }
        })
    };
    let slow: Vec<(usize, &VectorPortrait)> = all
        .iter()
        .copied()
        .filter(|(_, vector)| {
            matches!(vector.nature, Nature::Slow(_)) && !vector.is_complex && !used(vector)
        })
        .collect();
    let position = best(&slow, position_score, "position");
    let velocity = match position {
        Some(_) => None,
        None => best(&slow, velocity_score, "velocity"),
    };
    let motion = position.as_ref().or(velocity.as_ref());
    let direction = motion.map(|motion| direction(motion.vector, position.is_some()));
    let forces: Vec<(usize, &VectorPortrait)> = slow
        .into_iter()
        .filter(|(_, vector)| motion.is_none_or(|motion| !std::ptr::eq(motion.vector, *vector)))
        .collect();
    let correlation = |vector: &VectorPortrait| {
        direction
            .as_ref()
            .map(|direction| correlation(&vector.course, direction).abs())
    };
    let normal = best(
        &forces,
        |vector| force_score(vector, Role::Normal, correlation(vector)),
        "normal force",
    );
    let others: Vec<(usize, &VectorPortrait)> = forces
        .into_iter()
        .filter(|(_, vector)| {
            normal
                .as_ref()
                .is_none_or(|normal| !std::ptr::eq(normal.vector, *vector))
        })
        .collect();
    let lateral = best(
        &others,
        |vector| force_score(vector, Role::Lateral, correlation(vector)),
        "lateral force",
    );
    Roles {
        signals,
        envelopes,
        normal,
        lateral,
        position,
        velocity,
    }
}

fn signals<'a>(all: &[(usize, &'a VectorPortrait)]) -> Option<(Chosen<'a>, Chosen<'a>)> {
    let channels: Vec<(usize, &VectorPortrait, &Carrier)> = all
        .iter()
        .filter_map(|(file, vector)| match &vector.nature {
            Nature::Carrier(carrier) if !vector.is_complex => Some((*file, *vector, carrier)),
            _ => None,
        })
        .collect();
    let candidates: Vec<_> = channels
        .iter()
        .map(|(_, vector, carrier)| (*vector, *carrier))
        .collect();
    let pair = drive_pair(&candidates)?;
    let chosen = |index: usize| {
        let (file, vector, _) = channels[index];
        let reason = format!("{}; {}", vector.kind_text(), pair.evidence);
        Chosen {
            file,
            vector,
            reason,
            is_sure: pair.is_sure,
        }
    };
    Some((chosen(pair.drive), chosen(pair.pickup)))
}

/// Score of a vector for a role, with the reasons; `None` if it cannot have the role.
type Score = Option<(f64, Vec<String>)>;

/// Score from which on a role is sure, and least score of a role.
const SURE: f64 = 3.0;
const LEAST: f64 = 1.0;

/// Returns the vector with the best score.
fn best<'a>(
    vectors: &[(usize, &'a VectorPortrait)],
    score: impl Fn(&VectorPortrait) -> Score,
    role: &str,
) -> Option<Chosen<'a>> {
    let mut scored: Vec<_> = vectors
        .iter()
        .filter_map(|(file, vector)| {
            score(vector).map(|(score, reasons)| (score, reasons, *file, *vector))
        })
        .filter(|(score, ..)| *score >= LEAST)
        .collect();
    // A stable sort: of equal scores the first in the file.
    scored.sort_by(|a, b| b.0.total_cmp(&a.0));
    let rival = scored
        .get(1)
        .filter(|second| scored[0].0 - second.0 < 0.5)
        .map(|second| second.3.name.clone());
    let (score, mut reasons, file, vector) = scored.into_iter().next()?;
    if let Some(rival) = &rival {
        reasons.push(format!("`{rival}` may be the {role} as well"));
    }
    let reason = reasons.join("; ");
    Some(Chosen {
        file,
        vector,
        reason,
        is_sure: score >= SURE && rival.is_none(),
    })
}

fn named(vector: &VectorPortrait, role: Role) -> Option<f64> {
    match vector.role() {
        Some((found, _)) if found == role => Some(3.0),
        // Another meaning of the name excludes this one.
        Some(_) => None,
        None => Some(0.0),
    }
}

fn name_reason(score: f64, vector: &VectorPortrait) -> Vec<String> {
    let word = vector.role().map(|(_, word)| word);
    let reason = word
        .filter(|_| score > 0.0)
        .map(|word| format!("named {word:?}"));
    reason.into_iter().collect()
}

fn position_score(vector: &VectorPortrait) -> Score {
    let mut score = named(vector, Role::Position)?;
    let mut reasons = name_reason(score, vector);
    match vector.unit_meaning() {
        Some(UnitMeaning::Metres(_) | UnitMeaning::Counts | UnitMeaning::Pixels) => {
            score += 1.0;
            reasons.push(format!("in {}", vector.unit_text().unwrap_or_default()));
        }
        Some(_) => return None,
        None => {}
    }
    match &vector.nature {
        Nature::Slow(Slow::Travel(_) | Slow::Counts(_)) => score += 1.0,
        Nature::Slow(Slow::Levels(_)) => return None,
        _ => {}
    }
    reasons.push(vector.kind_text());
    Some((score, reasons))
}

fn velocity_score(vector: &VectorPortrait) -> Score {
    // `stage_mm_s` is named after a position, and its unit is that of a velocity.
    let has_unit = matches!(vector.unit_meaning(), Some(UnitMeaning::MetresPerSecond(_)));
    let is_place = has_unit && matches!(vector.role(), Some((Role::Position, _)));
    let mut score = if is_place {
        0.0
    } else {
        named(vector, Role::Velocity)?
    };
    let mut reasons = name_reason(score, vector);
    match vector.unit_meaning() {
        Some(UnitMeaning::MetresPerSecond(_)) => {
            score += 2.0;
            reasons.push(format!("in {}", vector.unit_text().unwrap_or_default()));
        }
        Some(_) => return None,
        None => {}
    }
    reasons.push(vector.kind_text());
    Some((score, reasons))
}

fn force_score(vector: &VectorPortrait, role: Role, correlation: Option<f64>) -> Score {
    let is_normal = role == Role::Normal;
    let mut score = named(vector, role)?;
    let mut reasons = name_reason(score, vector);
    match vector.unit_meaning() {
        Some(UnitMeaning::Newtons(_)) => {
            score += 1.0;
            reasons.push(format!("in {}", vector.unit_text().unwrap_or_default()));
        }
        Some(UnitMeaning::Volts(_)) | None => {}
        Some(_) => return None,
    }
    match &vector.nature {
        Nature::Slow(Slow::Steps(steps)) => {
            score += 1.0;
            // Friction oscillates with the film, the normal force hardly.
            let is_alike = match steps.modulation {
                Some(_) => !is_normal,
                None => steps.is_one_way() == is_normal,
            };
            if is_alike {
                score += 1.0;
            }
            reasons.push(vector.kind_text());
        }
        Nature::Slow(Slow::Levels(_) | Slow::Counts(_)) => return None,
        // A force under modulation oscillates with it.
        Nature::Slow(Slow::Oscillation(_)) => score += 0.5,
        Nature::Slow(_) => {}
        _ => return None,
    }
    if let Some(correlation) = correlation.filter(|correlation| correlation.is_finite()) {
        score += if is_normal {
            0.5 - correlation
        } else {
            correlation
        };
        if is_normal == (correlation < 0.3) {
            let text = if is_normal {
                "keeps its sign with the direction of travel"
            } else {
                "turns with the direction of travel"
            };
            reasons.push(format!("{text} (r {correlation:.2})"));
        }
    }
    Some((score, reasons))
}

/// Returns the direction of travel over the parts of a course: −1, 0 or 1.
fn direction(vector: &VectorPortrait, is_position: bool) -> Vec<f64> {
    let course = &vector.course;
    let velocity: Vec<f64> = match is_position {
        true => (0..course.len())
            .map(|i| course[(i + 1).min(course.len() - 1)] - course[i.saturating_sub(1)])
            .collect(),
        false => course.clone(),
    };
    let fastest = velocity
        .iter()
        .map(|v| v.abs())
        .filter(|v| v.is_finite())
        .fold(0.0, f64::max);
    velocity
        .iter()
        .map(|v| match v {
            v if v.is_nan() => f64::NAN,
            v if v.abs() < 0.2 * fastest => 0.0,
            v => v.signum(),
        })
        .collect()
}

/// Returns the correlation of two courses of the same length where both are known; NaN without one.
fn correlation(a: &[f64], b: &[f64]) -> f64 {
    if a.len() != b.len() {
        return f64::NAN;
    }
    let pairs: Vec<(f64, f64)> = a
        .iter()
        .copied()
        .zip(b.iter().copied())
        .filter(|(a, b)| a.is_finite() && b.is_finite())
        .collect();
    let count = pairs.len() as f64;
    let (mean_a, mean_b) = pairs
        .iter()
        .fold((0.0, 0.0), |(x, y), (a, b)| (x + a / count, y + b / count));
    let (mut covariance, mut a_variance, mut b_variance) = (0.0, 0.0, 0.0);
    for (a, b) in pairs {
        covariance += (a - mean_a) * (b - mean_b);
        a_variance += (a - mean_a).powi(2);
        b_variance += (b - mean_b).powi(2);
    }
    covariance / (a_variance * b_variance).sqrt()
}

/// Returns whether a normal force points down: its excursions are below rest; `None` if that is not certain.
pub(crate) fn is_upside_down(vector: &VectorPortrait) -> Option<bool> {
    match &vector.nature {
        Nature::Slow(Slow::Steps(steps @ Steps { balance, .. })) if steps.is_one_way() => {
            steps.is_rest_certain.then_some(*balance < 0.0)
        }
        _ => {
            let extremes = vector.extremes.as_ref()?;
            let is_clear = extremes.least.abs().max(extremes.greatest.abs())
                > 3.0 * extremes.least.abs().min(extremes.greatest.abs());
            is_clear.then_some(-extremes.least > extremes.greatest)
        }
    }
}

/// Finds complex envelopes of drive and pickup.
fn envelopes<'a>(all: &[(usize, &'a VectorPortrait)]) -> Option<EnvelopePair<'a>> {
    let mut found: Vec<(usize, EnvelopeArrays<'a>)> = Vec::new();
    for (file, vector) in all.iter().filter(|(_, vector)| vector.is_complex) {
        found.push((*file, EnvelopeArrays::Complex(vector)));
    }
    for (file, vector) in all.iter().filter(|(_, vector)| !vector.is_complex) {
        let partner = |is_partner: &dyn Fn(&str) -> bool| {
            let found = all.iter().find(|(other_file, candidate)| {
                other_file == file
                    && candidate.length == vector.length
                    && is_partner(&candidate.name)
            });
            found.map(|(_, candidate)| *candidate)
        };
        let ending = |ends: &[(&str, &str)]| {
            let name = ends.iter().find_map(|(end, candidate)| {
                let stem = vector.name.strip_suffix(end)?;
                Some(format!("{stem}{candidate}"))
            })?;
            partner(&|candidate| candidate == name)
        };
        let phase = || {
            ending(AMPLITUDE_AND_PHASE)
                .or_else(|| partner(&|candidate| polar::is_pair(&vector.name, candidate)))
        };
        if let Some(imaginary) = ending(REAL_AND_IMAGINARY) {
            found.push((*file, EnvelopeArrays::Parts(vector, imaginary)));
        } else if let Some(phase) = phase() {
            found.push((*file, EnvelopeArrays::Polar(vector, phase)));
        }
    }
    // A magnitude whose phase has a name of its own is followed by it.
    let mut is_by_order = false;
    if found.len() < 2 {
        for pair in all.windows(2) {
            let [(file, vector), (other_file, other)] = pair else {
                continue;
            };
            let is_free = |candidate: &VectorPortrait| {
                found.iter().all(|(_, arrays)| match arrays {
                    EnvelopeArrays::Complex(a) => !std::ptr::eq(*a, candidate),
                    EnvelopeArrays::Parts(a, b) | EnvelopeArrays::Polar(a, b) => {
                        !std::ptr::eq(*a, candidate) && !std::ptr::eq(*b, candidate)
                    }
                })
            };
            let is_pair = file == other_file
                && vector.length == other.length
                && matches!(vector.nature, Nature::Slow(Slow::Oscillation(_)))
                && polar::is_phase(&other.name)
                && !polar::is_phase(&vector.name)
                && is_free(vector)
                && is_free(other);
            if is_pair {
                is_by_order = true;
                found.push((*file, EnvelopeArrays::Polar(vector, other)));
            }
        }
    }
    // A position named X has no partner Y among envelopes of the same kind.
    let oscillates = |arrays: &EnvelopeArrays<'_>| {
        let both = match arrays {
            EnvelopeArrays::Complex(_) => return true,
            EnvelopeArrays::Parts(a, b) | EnvelopeArrays::Polar(a, b) => [*a, *b],
        };
        both.iter()
            .any(|vector| matches!(vector.nature, Nature::Slow(Slow::Oscillation(_))))
    };
    found.retain(|(_, arrays)| oscillates(arrays));
    // The word of a magnitude, as in `amp_2`, states no role.
    let name = |arrays: &EnvelopeArrays<'_>| {
        let name = &arrays.first().name;
        let rest = matches!(arrays, EnvelopeArrays::Polar(..)).then(|| polar::stream_of(name));
        rest.flatten().unwrap_or_else(|| name.clone())
    };
    let role =
        |arrays: &EnvelopeArrays<'_>| crate::names::role(&name(arrays)).map(|(role, _)| role);
    let is_drive = |arrays: &EnvelopeArrays<'_>| {
        let unit = arrays.first().unit_meaning();
        role(arrays) == Some(Role::Drive)
            || words_begin_with_u(&name(arrays))
            || (role(arrays).is_none() && matches!(unit, Some(UnitMeaning::Volts(_))))
    };
    let drive = found.iter().position(|(_, arrays)| is_drive(arrays));
    let (file, _) = found.first()?;
    let (drive_index, is_sure) = match drive {
        Some(index) => (index, found.len() == 2 && !is_by_order),
        None => (0, false),
    };
    let pickup_index =
        (0..found.len()).find(|index| *index != drive_index && found[*index].0 == *file)?;
    let reason = match drive {
        Some(_) if is_by_order => {
            "each magnitude with the phase after it; the drive by its name or its unit".to_owned()
        }
        Some(_) => "pairs by their names; the drive by its name or its unit".to_owned(),
        None => {
            "pairs by their names; nothing tells drive from pickup: taken in the order of the file"
                .to_owned()
        }
    };
    let (drive, pickup) = (found[drive_index].1.clone(), found[pickup_index].1.clone());
    let phases: Vec<&VectorPortrait> = [&drive, &pickup]
        .into_iter()
        .filter_map(|arrays| match arrays {
            EnvelopeArrays::Polar(_, phase) => Some(*phase),
            _ => None,
        })
        .collect();
    Some(EnvelopePair {
        file: *file,
        phases: (!phases.is_empty()).then(|| phase_unit(&phases)),
        drive,
        pickup,
        reason,
        is_sure,
    })
}

fn words_begin_with_u(name: &str) -> bool {
    crate::name_parts::words(&crate::name_parts::leaf(name))
        .first()
        .is_some_and(|word| word == "u" || word == "drive")
}

/// Ends of the names of real and imaginary parts, and of amplitudes and phases.
const REAL_AND_IMAGINARY: &[(&str, &str)] = &[
    ("X", "Y"),
    ("x", "y"),
    ("re", "im"),
    ("Re", "Im"),
    ("real", "imag"),
    ("I", "Q"),
    ("_i", "_q"),
    ("Real", "Imag"),
    ("RE", "IM"),
];
const AMPLITUDE_AND_PHASE: &[(&str, &str)] = &[
    ("R", "theta"),
    ("R", "Theta"),
    ("r", "theta"),
    ("R", "T"),
    ("amp", "phase"),
    ("mag", "phase"),
    ("Mag", "Phase"),
    ("amplitude", "phase"),
    ("abs", "arg"),
    ("r", "phi"),
    ("R", "phi"),
];
