//! Data of a figure as a table.

use crate::spec::{Figure, Mark};

impl Figure {
    /// Returns the drawn data as CSV: letter of the `panel`, name of the `series` (empty if the key omits it), `x`, `y`.
    /// A band has an empty `y` and its edges in `low` and `high`. A row that is empty after its series marks a break in a
    /// curve.
    pub fn to_csv(&self) -> String {
        let mut rows = csv::Writer::from_writer(Vec::new());
        let number = |value: f64| match value.is_finite() {
            true => value.to_string(),
            false => String::new(),
        };
        // Writing to memory does not fail.
        let _ = rows.write_record(["panel", "series", "x", "y", "low", "high"]);
        for (panel, letter) in self.panels.iter().zip('a'..) {
            for series in &panel.series {
                let name = &escaping::to_cell(series.name.as_deref().unwrap_or_default());
                let letter = letter.to_string();
                let mut row = |cells: [String; 4]| {
                    let _ = rows.write_record(
                        [letter.as_str(), name.as_str()]
                            .into_iter()
                            .chain(cells.iter().map(String::as_str)),
                    );
                };
                match &series.mark {
                    Mark::Line { points, .. } | Mark::Points { points, .. } => {
                        for &(x, y) in points {
                            row([number(x), number(y), String::new(), String::new()]);
                        }
                    }
                    Mark::Band { edges } | Mark::Bars { bars: edges } => {
                        for &(x, low, high) in edges {
                            row([number(x), String::new(), number(low), number(high)]);
                        }
                    }
                }
            }
        }
        let bytes = rows.into_inner().unwrap_or_default();
        String::from_utf8_lossy(&bytes).into_owned()
    }
}

#[cfg(test)]
mod tests {
    use crate::{Axis, Dash, Figure, Ink, Key, Marker, Panel, Series, Width};

    #[test]
    fn the_table_holds_every_point_its_panel_and_series() {
        let panel = |series| Panel {
            series,
            ..Panel::new(Axis::linear("x"), Axis::linear("y"))
        };
        let line = Series::line(
            Ink::Black,
            Dash::Solid,
            vec![(1.0, 0.5), (f64::NAN, f64::NAN)],
        );
        let points = Series::points(Ink::Blue, Marker::Disc, vec![(2.0, 1e-9)]);
        let figure = Figure {
            name: "some".to_owned(),
            title: String::new(),
            caption: String::new(),
            width: Width::Column,
            columns: 1,
            panel_height_mm: 30.0,
            footnote: None,
            key: Key::Above,
            panels: vec![
                panel(vec![line.with_name("paper, model")]),
                panel(vec![
                    points,
                    Series::band(Ink::Grey, vec![(0.0, -1.0, 1.0)]),
                ]),
            ],
        };
        let rows = [
            "panel,series,x,y,low,high",
            "a,\"paper, model\",1,0.5,,",
            "a,\"paper, model\",,,,",
            "b,,2,0.000000001,,",
            "b,,0,,-1,1",
        ];
        assert_eq!(figure.to_csv().lines().collect::<Vec<_>>(), rows);
    }
}
