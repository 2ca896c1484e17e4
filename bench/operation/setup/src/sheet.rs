//! The template of `bench.toml` as a form to fill in; its comments are kept.

use anyhow::{Context, bail};

/// The lines of the template.
pub struct Sheet {
    lines: Vec<String>,
}

impl Sheet {
    /// Creates a sheet from a fresh template.
    pub fn new() -> Self {
        Self {
            lines: config::TEMPLATE.lines().map(str::to_owned).collect(),
        }
    }

    /// Sets a key, which may be optional and commented out in the template.
    ///
    /// # Errors
    /// If the template has no such key.
    pub fn set(
        &mut self,
        table: &str,
        key: &str,
        value: impl Into<toml::Value>,
    ) -> anyhow::Result<()> {
        let place = self.place(table, key)?;
        let comment = comment(&self.lines[place]);
        let entry = format!("{key} = {}", value.into());
        self.lines[place] = match comment {
            Some(comment) => format!("{entry:<34} {comment}"),
            None => entry,
        };
        Ok(())
    }

    /// Disables a key by commenting it out in place.
    ///
    /// # Errors
    /// If the template has no such key.
    pub fn unset(&mut self, table: &str, key: &str) -> anyhow::Result<()> {
        let place = self.place(table, key)?;
        if !self.lines[place].starts_with('#') {
            self.lines[place].insert(0, '#');
        }
        Ok(())
    }

    /// Enables a key that is commented out in the template as an example.
    ///
    /// # Errors
    /// If the template has no such key.
    pub fn use_example(&mut self, table: &str, key: &str) -> anyhow::Result<()> {
        let place = self.place(table, key)?;
        let line = &mut self.lines[place];
        if line.starts_with('#') {
            line.remove(0);
        }
        Ok(())
    }

    /// Removes a table.
    ///
    /// # Errors
    /// If the template has no such table.
    pub fn remove(&mut self, table: &str) -> anyhow::Result<()> {
        let (start, end) = self.table(table)?;
        self.lines.drain(start..end);
        Ok(())
    }

    /// Returns the text of the file.
    pub fn text(&self) -> String {
        self.lines.join("\n") + "\n"
    }

    /// Returns the line range of a table, including its header.
    fn table(&self, table: &str) -> anyhow::Result<(usize, usize)> {
        let header = format!("[{table}]");
        let start = self
            .lines
            .iter()
            .position(|line| line.starts_with(&header))
            .with_context(|| format!("the template has no table {header}"))?;
        let next = |line: &String| line.starts_with('[');
        let end = self.lines[start + 1..].iter().position(next);
        Ok((start, end.map_or(self.lines.len(), |end| start + 1 + end)))
    }

    fn place(&self, table: &str, key: &str) -> anyhow::Result<usize> {
        let (start, end) = self.table(table)?;
        let is_key = |line: &String| {
            let line = line.strip_prefix('#').unwrap_or(line);
            line.split_once('=')
                .is_some_and(|(name, _)| name.trim_end() == key)
        };
        match self.lines[start..end].iter().position(is_key) {
            Some(place) => Ok(start + place),
            None => bail!("the template has no key {table}.{key}"),
        }
    }
}

/// Returns the comment after a line's value.
fn comment(line: &str) -> Option<&str> {
    let line = line.strip_prefix('#').unwrap_or(line);
    let mut quoted = false;
    let begin = line.char_indices().find(|&(_, letter)| {
        quoted ^= letter == '"';
        letter == '#' && !quoted
    });
    begin.map(|(begin, _)| &line[begin..])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(sheet: &Sheet, begin: &str) -> String {
        let text = sheet.text();
        let entry = text.lines().find(|line| line.starts_with(begin));
        entry.unwrap_or_else(|| panic!("no {begin}")).to_owned()
    }

    #[test]
    fn a_value_is_put_in_and_its_comment_stays() {
        let mut sheet = Sheet::new();
        sheet.set("audio", "rate_hz", 96_000).unwrap();
        let entry = line(&sheet, "rate_hz = 96000 ");
        assert!(entry.ends_with("# above twice the carrier and the modulation"));
        sheet.set("encoder", "source", "field-box").unwrap();
        line(&sheet, "source = \"field-box\"");
        sheet.set("plate", "id", "the \"big\" # one").unwrap();
        let text = sheet.text();
        let config = config::Config::parse(&text, "bench.toml").unwrap();
        assert_eq!(config.plate.id, "the \"big\" # one");
    }

    #[test]
    fn a_key_is_disabled_and_an_example_is_enabled() {
        let mut sheet = Sheet::new();
        sheet.unset("force", "port").unwrap();
        sheet.unset("force", "port").unwrap();
        line(&sheet, "#port = \"/dev/ttyUSB0\"");
        sheet.use_example("gpio", "estop").unwrap();
        line(&sheet, "estop = 13");
    }

    #[test]
    fn a_table_goes_with_all_its_keys_and_no_other() {
        let mut sheet = Sheet::new();
        sheet.remove("force.netft").unwrap();
        assert!(!sheet.text().contains("counts_per_n"));
        assert!(sheet.text().contains("[force.field_box]"));
        sheet.remove("force.netft").unwrap_err();
        sheet.set("force", "counts_per_n", 1).unwrap_err();
    }
}
