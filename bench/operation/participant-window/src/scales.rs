//! Widths of the monitors' pixels, as matched on the ruler page, stored in the user's configuration directory.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use strict_toml::TomlError;

/// Plausible range of a pixel's width, m.
const PIXEL_M: (f64, f64) = (1e-5, 2e-3);
/// Size limit of the file, bytes.
const LIMIT_BYTES: u64 = 1 << 20;

/// A monitor with a known scale.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Monitor {
    name: String,
    width_px: u32,
    height_px: u32,
    pixel_m: f64,
}

/// Contents of the file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Monitors {
    #[serde(default)]
    monitors: Vec<Monitor>,
}

/// Why the scales cannot be read or stored.
#[derive(Debug, thiserror::Error)]
pub enum ScalesError {
    /// The file is not a file of scales.
    #[error("{0}; delete the file, and redo the ruler page")]
    Toml(#[from] TomlError),
    /// A pixel is wider or narrower than any monitor's.
    #[error(
        "{file}: pixel_m = {pixel_m} m of monitor {monitor} is not a valid scale; delete the file, and redo the ruler \
         page"
    )]
    Pixel {
        /// The file.
        file: String,
        /// The monitor.
        monitor: String,
        /// The pixel's width, m.
        pixel_m: f64,
    },
    /// The file cannot be read or written.
    #[error("{file}: {}", bounded_files::cause(source))]
    File {
        /// The file.
        file: String,
        /// The system's reason.
        #[source]
        source: io::Error,
    },
    /// The user has no configuration directory.
    #[error(
        "neither XDG_CONFIG_HOME nor HOME is set: a monitor's scale cannot be stored; set one of them"
    )]
    NoHome,
}

/// The scales of the monitors.
#[derive(Clone, Debug)]
pub struct Scales {
    path: PathBuf,
    monitors: Monitors,
}

/// Returns the path of the file, from the environment's `XDG_CONFIG_HOME` and `HOME`.
///
/// # Errors
/// [`ScalesError::NoHome`].
pub fn path(config_home: Option<PathBuf>, home: Option<PathBuf>) -> Result<PathBuf, ScalesError> {
    let absolute = |path: PathBuf| path.is_absolute().then_some(path);
    let folder = config_home
        .and_then(absolute)
        .or_else(|| Some(home.and_then(absolute)?.join(".config")))
        .ok_or(ScalesError::NoHome)?;
    Ok(folder.join("friction-bench").join("monitors.toml"))
}

impl Scales {
    /// Reads the scales; empty if the file does not exist.
    ///
    /// # Errors
    /// [`ScalesError`], which names the file and the line.
    pub fn read(path: &Path) -> Result<Self, ScalesError> {
        let file = path.display().to_string();
        let text = match bounded_files::read_text(path, LIMIT_BYTES) {
            Ok(text) => text,
            Err(source) if source.kind() == io::ErrorKind::NotFound => String::new(),
            Err(source) => return Err(ScalesError::File { file, source }),
        };
        let monitors: Monitors = strict_toml::parse(&text, &file)?;
        let odd = |monitor: &&Monitor| !(PIXEL_M.0..=PIXEL_M.1).contains(&monitor.pixel_m);
        if let Some(odd) = monitors.monitors.iter().find(odd) {
            return Err(ScalesError::Pixel {
                file,
                monitor: odd.name.clone(),
                pixel_m: odd.pixel_m,
            });
        }
        Ok(Self {
            path: path.to_owned(),
            monitors,
        })
    }

    /// Returns the width of a monitor's pixels, m; `None` if it was never matched at this resolution.
    #[must_use]
    pub fn pixel_m(&self, name: &str, (width_px, height_px): (u32, u32)) -> Option<f64> {
        let is_same = |monitor: &&Monitor| {
            monitor.name == name && (monitor.width_px, monitor.height_px) == (width_px, height_px)
        };
        self.monitors
            .monitors
            .iter()
            .find(is_same)
            .map(|monitor| monitor.pixel_m)
    }

    /// Stores the width of a monitor's pixels; the file is replaced as a whole.
    ///
    /// # Errors
    /// [`ScalesError::File`].
    pub fn keep(
        &mut self,
        name: &str,
        (width_px, height_px): (u32, u32),
        pixel_m: f64,
    ) -> Result<(), ScalesError> {
        self.monitors.monitors.retain(|monitor| {
            monitor.name != name || (monitor.width_px, monitor.height_px) != (width_px, height_px)
        });
        self.monitors.monitors.push(Monitor {
            name: name.to_owned(),
            width_px,
            height_px,
            pixel_m,
        });
        self.write().map_err(|source| ScalesError::File {
            file: self.path.display().to_string(),
            source,
        })
    }

    fn write(&self) -> io::Result<()> {
        let text = toml::to_string(&self.monitors).map_err(io::Error::other)?;
        if let Some(folder) = self.path.parent() {
            fs::create_dir_all(folder)?;
        }
        let new = self
            .path
            .with_extension(format!("toml.{}", std::process::id()));
        let mut file = fs::File::create(&new)?;
        file.write_all(text.as_bytes())?;
        file.sync_all()?;
        fs::rename(&new, &self.path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_monitor_keeps_its_scale_at_its_resolution() {
        let folder = tempfile::tempdir().unwrap();
        let path = path(Some(folder.path().join("new")), None).unwrap();
        let mut scales = Scales::read(&path).unwrap();
        assert_eq!(scales.pixel_m("HDMI-1", (1920, 1080)), None);
        scales.keep("HDMI-1", (1920, 1080), 2.768e-4).unwrap();
        scales.keep("HDMI-1", (1280, 720), 4e-4).unwrap();
        scales.keep("HDMI-1", (1920, 1080), 2.77e-4).unwrap();
        let reread = Scales::read(&path).unwrap();
        assert_eq!(reread.pixel_m("HDMI-1", (1920, 1080)), Some(2.77e-4));
        assert_eq!(reread.pixel_m("HDMI-1", (1280, 720)), Some(4e-4));
        assert_eq!(reread.pixel_m("DP-1", (1920, 1080)), None);
        assert_eq!(reread.monitors.monitors.len(), 2);
    }

    #[test]
    fn an_invalid_file_is_refused_with_a_remedy() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("monitors.toml");
        let read_error = |text: &str| {
            fs::write(&path, text).unwrap();
            Scales::read(&path).unwrap_err().to_string()
        };
        let line = "name = \"A\"\nwidth_px = 1\nheight_px = 1\n";
        for text in [
            "garbage".to_owned(),
            format!("[[monitors]]\n{line}pixel_mm = 0.2\n"),
            format!("[[monitors]]\n{line}pixel_m = nan\n"),
            format!("[[monitors]]\n{line}pixel_m = 0.27\n"),
        ] {
            let error = read_error(&text);
            assert!(
                error.contains("monitors.toml") && error.contains("ruler page"),
                "{error}"
            );
        }
    }

    #[test]
    fn a_relative_or_absent_folder_is_not_used() {
        assert!(path(None, None).is_err());
        assert!(path(Some("here".into()), Some("there".into())).is_err());
        let resolved = path(Some("here".into()), Some("/home/anna".into())).unwrap();
        assert_eq!(
            resolved,
            Path::new("/home/anna/.config/friction-bench/monitors.toml")
        );
    }
}
