//! Page of the drill on the screen.

use tui::drill_view::{DrillResult, DrillView};

use crate::exercise::Exercise;
use crate::record::ExerciseRecord;

/// Page of the drill as last shown.
#[derive(Debug, Clone, Default)]
pub(crate) struct Page {
    last_view: Option<DrillView>,
    view: DrillView,
}

impl Page {
    pub fn new(exercises: usize) -> Self {
        Self {
            last_view: None,
            view: DrillView {
                exercises: exercises as u32,
                ..DrillView::default()
            },
        }
    }

    /// Turns to the next exercise.
    pub fn turn(&mut self) {
        self.view.exercise += 1;
    }

    /// Adds a finished exercise.
    pub fn add(&mut self, record: &ExerciseRecord) {
        self.view.results.push(DrillResult {
            fault: record.fault.name().to_owned(),
            met: record.met,
            words: record.words(),
        });
    }

    /// Returns the page if it differs from the one last shown.
    pub fn news(&mut self, exercise: &Exercise) -> Option<DrillView> {
        self.view.instruction = exercise.instruction();
        self.view.note = exercise.note().map(str::to_owned);
        self.view.asked = exercise.current_step();
        self.new_view()
    }

    /// Returns the page with another instruction, for the time without a bench.
    pub fn with_words(&mut self, instruction: String) -> Option<DrillView> {
        self.view.instruction = instruction;
        self.view.note = None;
        self.view.asked = tui::drill_view::DrillStep::Act;
        self.new_view()
    }

    /// Returns the page at the end of the drill.
    pub fn last(mut self) -> DrillView {
        self.view.instruction = "over: q leaves it.".to_owned();
        self.view.note = None;
        self.view.asked = tui::drill_view::DrillStep::Watch;
        self.view
    }

    fn new_view(&mut self) -> Option<DrillView> {
        (self.last_view.as_ref() != Some(&self.view)).then(|| {
            self.last_view = Some(self.view.clone());
            self.view.clone()
        })
    }
}
