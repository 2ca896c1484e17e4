//! Present run of the computer: its identifier, and its age by a clock that cannot be set.

use std::fs;

use crate::machine;

/// The computer's present run.
#[derive(Debug, Clone, PartialEq)]
pub struct Boot {
    /// Identifier of this run; `None` if the system gives none.
    pub id: Option<String>,
    /// Time since the computer was started, s, suspension included; 0 if the system does not give it.
    pub up_s: f64,
    /// Identifier of this computer; `None` if the system gives none.
    pub machine: Option<String>,
}

impl Boot {
    /// Reads the run and its age.
    #[must_use]
    pub fn now() -> Self {
        let read = |path: &str| fs::read_to_string(path).ok();
        let id = read("/proc/sys/kernel/random/boot_id");
        let up_s = read("/proc/uptime").and_then(|text| first_number(&text));
        let machine = machine::id();
        match (id, up_s) {
            (Some(id), Some(up_s)) => Self {
                id: Some(id.trim().to_owned()),
                up_s,
                machine,
            },
            _ => Self {
                id: None,
                up_s: 0.0,
                machine,
            },
        }
    }
}

fn first_number(text: &str) -> Option<f64> {
    let number: f64 = text.split_whitespace().next()?.parse().ok()?;
    (number.is_finite() && number >= 0.0).then_some(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(target_os = "linux")]
    fn the_computer_has_been_on_for_a_while_and_goes_on() {
        let first = Boot::now();
        let second = Boot::now();
        assert!(first.id.is_some());
        assert_eq!(first.id, second.id);
        assert!(first.up_s > 0.0 && second.up_s >= first.up_s);
    }
}
