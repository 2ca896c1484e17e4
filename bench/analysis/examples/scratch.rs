use contact::fit::{InstanceSeries, trial};
fn main() {
    for path in std::env::args().skip(1) {
        let settings = analysis::Settings::default();
        let a = analysis::analyse(&[std::path::PathBuf::from(&path)], &settings, |_| ());
        let found = a
            .recordings
            .into_iter()
            .next()
            .unwrap()
            .found
            .expect("found");
        println!(
            "== {path}: {} instances, rejected {:?}",
            found.instances.len(),
            found.rejected.iter().map(|r| &r.reason).collect::<Vec<_>>()
        );
        let conditions = found
            .z_p
            .unwrap()
            .conditions(settings.assumed(), found.manifest.carrier_hz);
        for i in &found.instances {
            let d = &i.dynamic;
            println!(
                "  dynamic sigma {:.4} zt {:.3} tau {:.2} y {:.3}",
                d.sigma_t_m * 1e6,
                d.z_t_n_s_per_m,
                d.tau_s.unwrap().0 * 1e3,
                (i.finger.z_p_n_s_per_m() - conditions.z_p_corrected_n_s_per_m).im
            );
        }
        let series: Vec<InstanceSeries> = found
            .instances
            .iter()
            .map(|i| i.samples.series(analysis::method::Method::Dynamic).unwrap())
            .collect();
        let t = std::time::Instant::now();
        let f = trial::fit(&series, &conditions, &trial::TrialOptions::default()).unwrap();
        println!("  floor {:?} lag {:?}", f.friction_floor, f.lateral_lag_s);
        println!(
            "  {:?} S {:.1} ± {:.1}% q0 {:.4e} ± {:.1}% eta {:.4} ± {:.1}% tau {:.3} ± {:.1}%  {:?}",
            f.verdict,
            f.contact_area_m2.value * 1e6,
            f.contact_area_m2.std * 100.,
            f.q0_rad_per_m.value,
            f.q0_rad_per_m.std * 100.,
            f.loss_factor.value,
            f.loss_factor.std * 100.,
            f.tau_s.value * 1e3,
            f.tau_s.std * 100.,
            t.elapsed()
        );
        for i in &f.instances {
            let tm = 0.5 * (i.series.time_s[0] + i.series.time_s[i.series.time_s.len() - 1]);
            print!("  t {tm:.3}");
            println!(
                " trial sigma {:.4} ± {:.4} zt {:.3} ± {:.3} y {:.3} ± {:.3} = {:.2} Hz rms mu {:.4}",
                i.sigma_t_m * 1e6,
                i.sigma_t_std_m * 1e6,
                i.z_t_n_s_per_m,
                i.z_t_std_n_s_per_m,
                i.plate_offset_n_s_per_m.im,
                i.plate_offset_std_n_s_per_m,
                -i.plate_offset_n_s_per_m.im
                    / (4. * std::f64::consts::PI * found.manifest.plate.modal_mass_kg),
                i.agreement.rms_mu
            );
        }
    }
}
