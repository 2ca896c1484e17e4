//! The page written by `analyze --report`.

use std::fs;

use serde_json::Value;

use super::{analyze, study};

#[test]
fn the_page_includes_the_results_and_needs_no_other_file() {
    let folder = tempfile::tempdir().unwrap();
    let (json, page) = (folder.path().join("a.json"), folder.path().join("a.html"));
    fs::write(&page, "<!DOCTYPE html>an older page").unwrap();
    let [json_name, page_name] = [&json, &page].map(|path| path.to_str().unwrap());
    let output = analyze(&["--json", json_name, "--report", page_name], &[study()]);
    assert!(output.status.success(), "{output:?}");
    let results: Value = serde_json::from_str(&fs::read_to_string(json).unwrap()).unwrap();
    let page = fs::read_to_string(page).unwrap();
    assert!(page.starts_with("<!DOCTYPE html>") && page.ends_with("</html>"));

    let recording = &results["recordings"][0];
    assert!(page.contains(recording["participant"].as_str().unwrap()));
    let instances = recording["instances"].as_array().unwrap();
    assert!(instances.len() >= 5);
    for instance in instances {
        for method in ["paper", "dynamic", "trial"] {
            let sigma_t_m = instance[method]["sigma_t_m"].as_f64().unwrap();
            let cell = format!("<td class=\"n\">{:.3}<span", sigma_t_m * 1e6);
            assert!(page.contains(&cell), "{method}: {cell}");
        }
    }
    for (_, row) in results["statistics"].as_object().unwrap() {
        let n = row["trial"]["n"].as_u64().unwrap();
        let over = row["trial"]["over"].as_str().unwrap();
        assert!(page.contains(&format!("n = {n} {over}")));
    }
    // A single trial gives its own value, with the prior's part removed.
    let person = &results["skin"]["participants"][0];
    assert_eq!(person["participant"], recording["participant"]);
    let q0 = person["q0_rad_per_m"]["value"].as_f64().unwrap();
    let raw = recording["trial"]["q0_rad_per_m"].as_f64().unwrap();
    assert!((q0 / raw - 1.0).abs() < 0.1, "{q0} {raw}");
    let cell = format!("<td class=\"n\">{:.2}<span", q0 * 1e-4);
    assert!(page.contains(&cell), "{cell}");
    assert!(page.contains("accepted") && page.contains("without a calibration"));
    assert_eq!(page.matches("<svg").count(), 7);
    for outside in ["http", "src=", "<script", "<link", "url("] {
        assert!(!page.contains(outside), "{outside}");
    }
    let study_folder = study().parent().unwrap().to_str().unwrap();
    assert!(!page.contains(study_folder));
    let files: Vec<_> = fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name())
        .collect();
    assert_eq!(files.len(), 2, "{files:?}");
}

#[test]
fn a_page_that_cannot_be_written_is_refused_before_the_analysis() {
    let folder = tempfile::tempdir().unwrap();
    let unwritable = folder.path().join("none").join("a.html");
    for (option, path) in [
        ("--report", unwritable.as_path()),
        ("--report", folder.path()),
        ("--json", unwritable.as_path()),
    ] {
        // The recording does not exist either, which a started analysis would report.
        let output = analyze(
            &[option, path.to_str().unwrap()],
            &[&folder.path().join("absent")],
        );
        assert!(!output.status.success());
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(
            stderr.contains("cannot write") && !stderr.contains("absent"),
            "{stderr}"
        );
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}
