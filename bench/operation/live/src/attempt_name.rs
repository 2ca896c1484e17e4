//! Names of attempts on the operator's screen, which knows only its own types.

use protocols::TrialLabel;
use tui::action::AttemptName;

/// Returns the name of an attempt on the screen.
pub fn attempt_name(label: TrialLabel) -> AttemptName {
    AttemptName {
        trial: label.number,
        practice: label.is_practice(),
        attempt: label.attempt,
    }
}

/// Returns the label of an attempt that the screen names.
pub fn label(name: AttemptName) -> TrialLabel {
    TrialLabel::of_block(name.practice, name.trial, name.attempt)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_and_its_label_denote_one_attempt() {
        for text in ["practice-02_attempt-1", "trial-003_attempt-2"] {
            let parsed: TrialLabel = text.parse().unwrap();
            assert_eq!(label(attempt_name(parsed)), parsed);
        }
        let name = attempt_name("practice-02_attempt-1".parse().unwrap());
        assert_eq!(name.to_string(), "practice 2");
    }
}
