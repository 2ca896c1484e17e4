//! The page of trials: every attempt of the session, and the details of the selected one.

use ratatui::buffer::Buffer;
use ratatui::layout::{Constraint, Layout, Rect, Spacing};

use super::Room;
use crate::panels::{trial_crop, trial_list};
use crate::state::State;

pub(crate) fn render(state: &State, room: Room, area: Rect, buf: &mut Buffer) {
    let shares = match room {
        Room::Small => [Constraint::Length(26), Constraint::Fill(1)],
        Room::Medium => [Constraint::Length(40), Constraint::Fill(1)],
        Room::Large => [Constraint::Length(64), Constraint::Fill(1)],
    };
    let [list, chosen] = Layout::horizontal(shares)
        .spacing(Spacing::Space(2))
        .areas(area);
    trial_list::render(state, true, list, buf);
    trial_crop::render(state, chosen, buf);
}
