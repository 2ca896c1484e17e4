//! scratch
use contact::fit::{InstanceSeries, trial};
fn main() {
    for path in std::env::args().skip(1) {
        let settings = analysis::Settings::default();
        let a = analysis::analyse(&[std::path::PathBuf::from(&path)], &settings, |_| ());
        let Ok(found) = a.recordings.into_iter().next().unwrap().found else {
            continue;
        };
        let Some(z_p) = found.z_p else { continue };
        let conditions = z_p.conditions(settings.assumed(), found.manifest.carrier_hz);
        let series: Vec<InstanceSeries> = found
            .instances
            .iter()
            .map(|i| i.samples.series(analysis::method::Method::Dynamic).unwrap())
            .collect();
        if series.is_empty() {
            println!("{{\"path\":\"{path}\",\"instances\":[]}}");
            continue;
        }
        let t = std::time::Instant::now();
        let f = match trial::fit(&series, &conditions, &trial::TrialOptions::default()) {
            Ok(f) => f,
            Err(e) => {
                eprintln!("{path}: {e}");
                continue;
            }
        };
        let el = t.elapsed().as_secs_f64();
        let mut out = format!(
            "{{\"path\":\"{path}\",\"fit_s\":{el},\"verdict\":\"{}\",\"S\":[{},{}],\"q0\":[{},{}],\"eta\":[{},{}],\"tau\":[{},{}],\"floor\":{},\"lag\":{},\"mp\":{},\"instances\":[",
            f.verdict,
            f.contact_area_m2.value,
            f.contact_area_m2.std,
            f.q0_rad_per_m.value,
            f.q0_rad_per_m.std,
            f.loss_factor.value,
            f.loss_factor.std,
            f.tau_s.value,
            f.tau_s.std,
            f.friction_floor.map_or(-1., |v| v.value),
            f.lateral_lag_s.map_or(-1., |v| v.value),
            found.manifest.plate.modal_mass_kg
        );
        for (k, (i, t)) in found.instances.iter().zip(&f.instances).enumerate() {
            if k > 0 {
                out += ",";
            }
            let d = &i.dynamic;
            out += &format!(
                "{{\"t\":[{},{}],\"dyn\":[{},{},{},{},{},{},{},{},{}],\"tri\":[{},{},{},{},{},{},{},{},{}],\"rms_z\":{},\"pap\":[{},{},{}]}}",
                i.start_s,
                i.end_s,
                d.sigma_t_m,
                d.sigma_t_std_m,
                d.z_t_n_s_per_m.re,
                d.z_t_n_s_per_m.im,
                d.z_t_std_n_s_per_m.re,
                d.z_t_std_n_s_per_m.im,
                d.mu0,
                d.agreement.rms_mu,
                (i.finger.z_p_n_s_per_m() - conditions.z_p_corrected_n_s_per_m).im,
                t.sigma_t_m,
                t.sigma_t_std_m,
                t.z_t_n_s_per_m.re,
                t.z_t_n_s_per_m.im,
                t.z_t_std_n_s_per_m.re,
                t.z_t_std_n_s_per_m.im,
                t.mu0,
                t.agreement.rms_mu,
                t.plate_offset_n_s_per_m.im,
                t.agreement.rms_impedance_n_s_per_m,
                i.paper.sigma_t_m,
                i.paper.z_t_n_s_per_m.re,
                i.paper.z_t_n_s_per_m.im
            );
        }
        println!("{out}]}}");
    }
}
