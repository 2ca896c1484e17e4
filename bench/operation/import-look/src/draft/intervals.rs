//! Tables of the contact and of intervals.

use super::Draft;
use crate::map_text::{check, quoted, sure};
use crate::nature::Nature;
use crate::purpose::Family;
use crate::roles::Roles;
use crate::scales::{exploration, has_force_unit, is_ever_unloaded, newtons};
use crate::slow::Slow;

/// Largest force of a finger in experiments, N.
const MOST_OF_FINGER_N: f64 = 20.0;

impl Draft<'_> {
    pub(super) fn contact(&mut self, roles: &Roles<'_>) {
        self.map.table("contact");
        let forces = [&roles.normal, &roles.lateral].into_iter().flatten();
        let largest = forces.filter_map(|chosen| {
            let extremes = chosen.vector.extremes.as_ref()?;
            let size = extremes.greatest.abs().max(extremes.least.abs());
            has_force_unit(chosen.vector).then(|| size * newtons(chosen.vector, None).0.abs())
        });
        let largest_n = largest.fold(0.0, f64::max);
        let reason =
            check("a finger or another body? \"other\" turns the ranges off that hold for fingers");
        self.map.key(
            "body",
            if largest_n > MOST_OF_FINGER_N {
                "\"other\""
            } else {
                "\"finger\""
            },
            reason,
        );
    }

    pub(super) fn intervals(&mut self, roles: &Roles<'_>, marks: Option<&Family>) {
        self.map.table("intervals");
        if let Some(marks) = marks {
            let (name, reason) =
                self.other_file(&marks.files, "it has the columns kind, start_s and end_s");
            self.map.key("marks", &name, reason);
            return;
        }
        if let Some(normal) = &roles.normal {
            let is_clear = match &normal.vector.nature {
                Nature::Slow(Slow::Steps(steps)) if has_force_unit(normal.vector) => {
                    newtons(normal.vector, None).0.abs() * steps.up.max(steps.down) > 0.2
                }
                _ => false,
            };
            let text = "the finger presses with more; a sensor's noise is less";
            let reason = match (is_clear, is_ever_unloaded(normal.vector, 0.05, 0.3)) {
                (_, Some(false)) => check(
                    "no stretch looked at keeps to this rule with the factor above: correct that, or the rule, or state marks",
                ),
                (true, _) => sure(text),
                (false, _) => check(format!("{text}: is it so here?")),
            };
            self.map
                .key("unloaded", "\"normal < 0.05 N for 0.3 s\"", reason);
        } else {
            self.map.comment("unloaded needs a normal force or marks: without it, the plate is not read without a finger");
        }
        match (roles.position.as_ref(), roles.velocity.as_ref()) {
            (Some(chosen), _) | (None, Some(chosen)) => {
                let (rule, reason) = exploration(chosen.vector, roles.position.is_none());
                self.map.key("exploration", &quoted(&rule), reason);
            }
            (None, None) => self
                .map
                .comment("exploration needs a position, a velocity, or marks"),
        }
    }
}
