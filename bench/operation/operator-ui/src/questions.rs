//! The questions about the participant at a session's start, after consent and before anything is driven.

use protocols::{MAX_AGE_YEARS, MIN_AGE_YEARS, NOT_STATED, Person, PersonDetail};
use tui::calibration_page::Reply;
use tui::event::AskedDetail;

/// Questions about a participant, one after the other; each may be left unanswered.
#[derive(Debug, Default)]
pub struct Questions {
    details: Vec<PersonDetail>,
    /// Index of the current question, from 0.
    index: usize,
    person: Person,
    /// Why the last answer was rejected.
    note: Option<String>,
}

impl Questions {
    /// Creates the questions for `details`, in their order.
    #[must_use]
    pub fn new(details: Vec<PersonDetail>) -> Self {
        Self {
            details,
            ..Self::default()
        }
    }

    /// Returns whether a question is still open.
    #[must_use]
    pub fn are_open(&self) -> bool {
        self.index < self.details.len()
    }

    /// Returns the current question, as the screen shows it; `None` after the last.
    #[must_use]
    pub fn current(&self) -> tui::Event {
        let detail = self.details.get(self.index).map(|detail| AskedDetail {
            question: self.question(*detail),
            choices: detail.words().iter().map(ToString::to_string).collect(),
            note: self.note.clone(),
            has_previous: self.index > 0,
        });
        tui::Event::Asked { detail }
    }

    /// Returns the words of a question, with the answer that was given before.
    fn question(&self, detail: PersonDetail) -> String {
        let question = match detail {
            PersonDetail::Age => "age in whole years",
            PersonDetail::Sex => "sex",
            PersonDetail::Handedness => "writing hand",
        };
        match self.stated(detail) {
            Some(answer) => format!("{question} ({answer}: enter alone keeps it, 0: not stated)"),
            None => question.to_owned(),
        }
    }

    fn stated(&self, detail: PersonDetail) -> Option<String> {
        Some(self.person.text(detail)).filter(|text| text != NOT_STATED)
    }

    /// Takes the operator's reply to the current question. Returns the stated details once the last one is answered.
    pub fn reply(&mut self, reply: Reply) -> Option<Person> {
        let detail = *self.details.get(self.index)?;
        self.note = None;
        let text = match reply {
            Reply::Redo(_) => {
                self.index = self.index.saturating_sub(1);
                return None;
            }
            Reply::Ready => self.stated(detail).unwrap_or_else(|| NOT_STATED.to_owned()),
            Reply::Number(0.0) if self.stated(detail).is_some() => NOT_STATED.to_owned(),
            Reply::Number(number) => match detail.words() {
                [] => number.to_string(),
                words => match choice(words, number) {
                    Some(word) => word.to_owned(),
                    None => {
                        self.note = Some(format!("a number from 1 to {}", words.len()));
                        return None;
                    }
                },
            },
        };
        if let Err(error) = self.person.set(detail, &text) {
            self.note = Some(match detail {
                // The keys of the question are digits, so that `n/a` cannot be typed.
                PersonDetail::Age => format!(
                    "{text} is not an age: {MIN_AGE_YEARS} to {MAX_AGE_YEARS} whole years; enter alone: not stated"
                ),
                _ => error.to_string(),
            });
            return None;
        }
        self.index += 1;
        (!self.are_open()).then_some(self.person)
    }
}

/// Returns the word chosen by its number, counted from 1.
fn choice<'a>(words: &[&'a str], number: f64) -> Option<&'a str> {
    let mut numbered = (1..).zip(words);
    numbered.find_map(|(n, word)| (f64::from(n) == number).then_some(*word))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn current_detail(questions: &Questions) -> Option<AskedDetail> {
        match questions.current() {
            tui::Event::Asked { detail } => detail,
            event => panic!("{event:?}"),
        }
    }

    #[test]
    fn every_question_is_answered_or_left_and_a_slip_is_taken_back() {
        let mut questions = Questions::new(PersonDetail::ALL.to_vec());
        assert_eq!(questions.reply(Reply::Number(31.0)), None);
        assert_eq!(current_detail(&questions).unwrap().choices.len(), 3);
        assert_eq!(questions.reply(Reply::Number(2.0)), None);
        assert_eq!(questions.reply(Reply::Redo(0)), None);
        // Regression test: the answers before were lost on the way back.
        assert_eq!(questions.reply(Reply::Redo(0)), None);
        let question = current_detail(&questions).unwrap().question;
        assert_eq!(
            question,
            "age in whole years (31: enter alone keeps it, 0: not stated)"
        );
        assert_eq!(questions.reply(Reply::Ready), None);
        assert_eq!(questions.reply(Reply::Number(1.0)), None);
        let person = questions.reply(Reply::Number(2.0)).unwrap();
        let answers = PersonDetail::ALL.map(|detail| person.text(detail));
        assert_eq!(answers, ["31", "female", "left"]);
        assert_eq!(current_detail(&questions), None);
        assert_eq!(questions.reply(Reply::Number(1.0)), None);
    }

    #[test]
    fn an_invalid_answer_is_asked_again_with_the_reason() {
        let mut questions = Questions::new(vec![PersonDetail::Age, PersonDetail::Sex]);
        for no_age in [17.0, 121.0, 30.5, -30.0, 1e300] {
            assert_eq!(questions.reply(Reply::Number(no_age)), None);
            assert!(
                current_detail(&questions).unwrap().note.is_some(),
                "{no_age}"
            );
        }
        assert_eq!(questions.reply(Reply::Ready), None);
        for no_choice in [0.0, 4.0, 1.5, -1.0] {
            assert_eq!(questions.reply(Reply::Number(no_choice)), None);
            assert!(
                current_detail(&questions).unwrap().note.is_some(),
                "{no_choice}"
            );
        }
        // Going back from the first question stays there.
        for _ in 0..3 {
            assert_eq!(questions.reply(Reply::Redo(0)), None);
        }
        assert!(current_detail(&questions).unwrap().choices.is_empty());
        assert!(questions.are_open());
    }
}
