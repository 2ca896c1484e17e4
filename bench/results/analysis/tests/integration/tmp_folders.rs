#[test]
fn tmp_folders() {
    use rayon::prelude::*;
    let Ok(list) = std::env::var("TMP_FOLDERS") else {
        return;
    };
    let folders: Vec<String> = std::fs::read_to_string(list)
        .unwrap()
        .lines()
        .map(str::to_owned)
        .collect();
    folders.par_iter().for_each(|f| {
        let r = analysis::recording_analysis::analyse(
            std::path::Path::new(f),
            &analysis::Settings::default(),
        );
        match r.findings {
            Ok(x) => eprintln!(
                "FOLDER {f} instances {} misfit {:?} S {:?}",
                x.instances.len(),
                x.trial.as_ref().map(|t| t.misfit.clone()),
                x.trial.as_ref().map(|t| t.contact_area_m2)
            ),
            Err(e) => eprintln!("FOLDER {f} {e}"),
        }
    });
}
