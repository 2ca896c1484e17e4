//! The periodic film, compared with closed forms and with a finer grid. The README has the measured errors.

#![expect(
    clippy::unwrap_used,
    reason = "a helper that fails fails its test, as in the tests themselves"
)]
#![expect(clippy::print_stdout, reason = "README.md has the numbers from here")]

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;
use std::process::{Command, Stdio};

use num_complex::Complex64;

use super::programs::PROBE;

pub const AMBIENT_PA: f64 = 101_325.0;
const VISCOSITY_PA_S: f64 = 1.82e-5;
pub const OMEGA: f64 = TAU * 35e3;
/// Cells and steps of the recordings' films.
pub const RECORDED: (u32, u32) = (40, 48);

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    Strip,
    Disc,
}

const SHAPES: [Shape; 2] = [Shape::Strip, Shape::Disc];

/// Groove beside a strip.
#[derive(Debug, Clone, Copy)]
pub struct Groove {
    pub half_width_m: f64,
    pub depth_m: f64,
    pub length_m: f64,
}

/// Film over a strip, a ridge with its groove, or a disc.
#[derive(Debug, Clone, Copy)]
pub struct Film {
    pub shape: Shape,
    pub half_width_m: f64,
    pub squeeze: f64,
    /// Amplitude over gap.
    pub ratio: f64,
    pub wavelength_m: Option<f64>,
    pub groove: Option<Groove>,
}

impl Film {
    /// Returns a film of 5 mm half width without a groove.
    pub fn new(shape: Shape, squeeze: f64, ratio: f64) -> Self {
        Self {
            shape,
            half_width_m: 5e-3,
            squeeze,
            ratio,
            wavelength_m: None,
            groove: None,
        }
    }

    /// Returns the film of this half width at a gap.
    pub fn at_gap(self, half_width_m: f64, gap_m: f64, ratio: f64) -> Self {
        let squeeze = 12.0 * VISCOSITY_PA_S * OMEGA / AMBIENT_PA * (half_width_m / gap_m).powi(2);
        Self {
            half_width_m,
            squeeze,
            ratio,
            ..self
        }
    }

    fn gap_m(&self) -> f64 {
        self.half_width_m * (12.0 * VISCOSITY_PA_S * OMEGA / (AMBIENT_PA * self.squeeze)).sqrt()
    }
}

/// Mean overpressure and component at the carrier, over ambient pressure.
#[derive(Debug, Clone, Copy)]
pub struct Response {
    pub mean: f64,
    pub carrier: Complex64,
}

/// Returns the periodic states of films on a grid of cells and steps.
pub fn responses(films: &[Film], (cells, steps): (u32, u32)) -> Vec<Response> {
    let folder = tempfile::tempdir().unwrap();
    let program = PROBE.compile(folder.path());
    let mut lines = String::new();
    for film in films {
        let groove = film.groove.map_or([0.0; 3], |groove| {
            [groove.half_width_m, groove.depth_m, groove.length_m]
        });
        writeln!(
            lines,
            "{} {cells} {steps} {:e} {:e} {:e} {OMEGA:e} {VISCOSITY_PA_S:e} {AMBIENT_PA:e} {:e} {:e} {:e} {:e}",
            u8::from(film.shape == Shape::Disc),
            film.half_width_m,
            film.gap_m(),
            film.ratio,
            film.wavelength_m.unwrap_or(0.0),
            groove[0],
            groove[1],
            groove[2],
        )
        .unwrap();
    }
    let input = folder.path().join("films");
    fs::write(&input, lines).unwrap();
    let output = Command::new(program)
        .stdin(fs::File::open(input).unwrap())
        .stderr(Stdio::inherit())
        .output()
        .unwrap();
    assert!(output.status.success());
    let text = String::from_utf8(output.stdout).unwrap();
    let answers: Vec<Response> = text
        .lines()
        .zip(films)
        .map(|(line, film)| {
            let numbers: Vec<f64> = line.split(' ').map(|n| n.parse().unwrap()).collect();
            assert!((numbers[0] / film.squeeze - 1.0).abs() < 1e-6);
            Response {
                mean: numbers[1] / AMBIENT_PA,
                carrier: Complex64::new(numbers[2], numbers[3]) / AMBIENT_PA,
            }
        })
        .collect();
    assert_eq!(answers.len(), films.len());
    answers
}

/// Largest error of a quantity over all films.
struct Worst(&'static str, f64);

impl Worst {
    fn include(&mut self, error: f64, film: &Film) {
        assert!(error.is_finite(), "{}: {film:?}", self.0);
        if error.abs() > self.1 {
            self.1 = error.abs();
        }
    }

    fn assert_below(&self, limit: f64) {
        println!("{}: at most {:.5}", self.0, self.1);
        assert!(self.1 < limit, "{}: {} > {limit}", self.0, self.1);
    }
}

/// I1(z)/I0(z) by its continued fraction (Abramowitz & Stegun 1964, 9.1.73, for imaginary arguments).
fn bessel_ratio(z: Complex64) -> Complex64 {
    let terms = 60 + 2 * z.norm() as u32;
    let mut tail = Complex64::ZERO;
    for n in (1..=terms).rev() {
        tail = 1.0 / (f64::from(2 * n) / z + tail);
    }
    tail
}

/// Linear theory of the film (Langlois 1962): with q² = iσ the pressure is p_a(1 + ε Re Π e^{iθ}), where
/// Π = 1 − cosh(qX)/cosh q for a strip and 1 − I0(qX)/I0(q) for a disc. Their means over the area are 1 − tanh(q)/q and
/// 1 − 2 I1(q)/(q I0(q)).
pub struct Linear {
    pub shape: Shape,
    q: Complex64,
}

impl Linear {
    pub fn new(shape: Shape, squeeze: f64) -> Self {
        let q = Complex64::new(0.0, squeeze).sqrt();
        Self { shape, q }
    }

    /// Derivative of the logarithm of cosh(qX) or I0(qX).
    fn log_slope(&self, x: f64) -> Complex64 {
        let z = self.q * x;
        match self.shape {
            Shape::Strip => self.q * z.tanh(),
            Shape::Disc => self.q * bessel_ratio(z),
        }
    }

    /// Returns the mean of Π.
    pub fn mean_pressure(&self) -> Complex64 {
        let dimension = match self.shape {
            Shape::Strip => 1.0,
            Shape::Disc => 2.0,
        };
        1.0 - dimension * self.log_slope(1.0) / (self.q * self.q)
    }

    /// Mean overpressure over ε² p_a, to second order. Where the gap is uniform, the mean of Reynolds' equation over a period says
    /// ⟨h³ ∂(p²)/∂x⟩ = 0, which with p = 1 + ε p1 + ε² p2 and h = 1 + ε h1 is p2 = −⟨p1²⟩/2 − 3⟨h1 p1⟩ = −|Π|²/4 + 3 Re Π/2
    /// (derived here; the expansion is that of Minikes & Bucher 2006).
    pub fn mean_overpressure(&self) -> f64 {
        const PARTS: u32 = 4000;
        let x_at = |i: u32| f64::from(i) / f64::from(PARTS);
        let mut shape_at = Complex64::ONE;
        let (mut sum, mut area) = (0.0, 0.0);
        for i in (0..PARTS).rev() {
            let width = 1.0 / f64::from(PARTS);
            let middle = x_at(i) + width / 2.0;
            let half = (self.log_slope(middle) * (-width / 2.0)).exp();
            let pi = 1.0 - shape_at * half;
            let weight = match self.shape {
                Shape::Strip => width,
                Shape::Disc => middle * width,
            };
            sum += weight * (1.5 * pi.re - pi.norm_sqr() / 4.0);
            area += weight;
            shape_at *= half * half;
        }
        sum / area
    }
}

#[test]
fn small_amplitudes_follow_the_linear_theory_and_its_second_order() {
    const RATIO: f64 = 0.01;
    let squeezes = [0.003, 0.03, 0.3, 1.0, 3.0, 10.0, 100.0, 1e3, 1e4, 3e4];
    let films: Vec<Film> = SHAPES
        .into_iter()
        .flat_map(|shape| squeezes.map(|squeeze| Film::new(shape, squeeze, RATIO)))
        .collect();
    let mut carrier = Worst("linear carrier", 0.0);
    let mut mean = Worst("mean to second order", 0.0);
    for (film, response) in films.iter().zip(responses(&films, RECORDED)) {
        let linear = Linear::new(film.shape, film.squeeze);
        carrier.include(
            (response.carrier / RATIO / linear.mean_pressure() - 1.0).norm(),
            film,
        );
        mean.include(
            response.mean / (RATIO * RATIO) / linear.mean_overpressure() - 1.0,
            film,
        );
    }
    carrier.assert_below(0.003);
    mean.assert_below(0.01);
}

/// Where σ → ∞, no gas leaves: p h is constant in time but in a layer of thickness 1/√σ at the edge, over which ⟨h p² h²⟩ = ⟨h ψ²⟩ is
/// constant. So ψ² = p_a² g² (1 + 3ε²/2), and the mean of p = ψ/h is p_a √((1 + 3ε²/2)/(1 − ε²)) (Taylor & Saffman 1957; Salbu 1964).
/// The layer takes off a part ∝ 1/√σ. At the carrier the trapped gas is a spring: 1/h has the first harmonic
/// 2 (1/√(1 − ε²) − 1)/ε, for small ε ε: the stiffness is p_a S/g.
#[test]
fn large_squeeze_numbers_reach_the_limit_of_trapped_gas() {
    let ratios = [0.05, 0.1, 0.3, 0.5, 0.8, 0.9, 0.95];
    let mut mean = Worst("Salbu's mean, extrapolated", 0.0);
    let mut spring = Worst("spring of trapped gas, extrapolated", 0.0);
    for shape in SHAPES {
        let at = |squeeze: f64| ratios.map(|ratio| Film::new(shape, squeeze, ratio));
        let (near, far) = (at(1e4), at(4e4));
        let pairs = responses(&near, RECORDED)
            .into_iter()
            .zip(responses(&far, RECORDED));
        for (film, (near, far)) in near.iter().zip(pairs) {
            let square = film.ratio * film.ratio;
            let density = (1.0 + 1.5 * square).sqrt();
            let limit = density / (1.0 - square).sqrt() - 1.0;
            let (near_lack, far_lack) = (1.0 - near.mean / limit, 1.0 - far.mean / limit);
            assert!((0.4..0.65).contains(&(far_lack / near_lack)), "{film:?}");
            mean.include(near_lack - 2.0 * far_lack, film);
            let stiffness = density * 2.0 * (1.0 / (1.0 - square).sqrt() - 1.0) / film.ratio;
            spring.include(
                (2.0 * far.carrier.re - near.carrier.re) / stiffness - 1.0,
                film,
            );
            if film.ratio < 0.06 {
                assert!((far.carrier.re / film.ratio - 1.0).abs() < 0.02, "{film:?}");
            }
        }
    }
    mean.assert_below(0.002);
    spring.assert_below(0.002);
}

/// Where σ → 0, the gas is incompressible. A strip of width b and length l that approaches at v feels μ l (b/h)³ v, a disc
/// 3π μ R⁴ v/(2 h³) (Stefan 1874; Reynolds 1886). Over a cycle h = g(1 − ε cos θ), and the first harmonic of ε sin θ/(1 − ε cos θ)³ is
/// ε/(1 − ε²)^(3/2).
#[test]
fn small_squeeze_numbers_damp_as_an_incompressible_film() {
    let mut damping = Worst("incompressible damping", 0.0);
    for shape in SHAPES {
        let films = [0.01, 0.3, 0.5, 0.8].map(|ratio| Film::new(shape, 3e-5, ratio));
        for (film, response) in films.iter().zip(responses(&films, RECORDED)) {
            let (g, l) = (film.gap_m(), film.half_width_m);
            let force_per_area = match shape {
                Shape::Strip => VISCOSITY_PA_S * (2.0 * l).powi(3) / (g * g * g) / (2.0 * l),
                Shape::Disc => 1.5 * VISCOSITY_PA_S * l * l / (g * g * g),
            };
            let velocity = OMEGA * g * film.ratio;
            let expected_pa =
                force_per_area * velocity * (1.0 - film.ratio * film.ratio).powf(-1.5);
            damping.include(response.carrier.im * AMBIENT_PA / expected_pa - 1.0, film);
            assert!(response.carrier.re.abs() < 0.01 * response.carrier.im);
        }
    }
    damping.assert_below(0.002);
}

/// Ridges, strips and discs of all squeeze numbers of the recordings.
fn films_of_all_kinds() -> Vec<Film> {
    let groove = Groove {
        half_width_m: 6e-5,
        depth_m: 6e-5,
        length_m: 5e-3,
    };
    let mut films = Vec::new();
    for squeeze in [0.03, 0.5, 10.0, 300.0, 3e4] {
        for ratio in [0.1, 0.6, 0.95] {
            let strip = Film::new(Shape::Strip, squeeze, ratio);
            let disc = Film::new(Shape::Disc, squeeze, ratio);
            films.extend([strip, disc]);
            films.push(Film {
                wavelength_m: Some(22e-3),
                ..disc
            });
            let ridge = Film {
                half_width_m: 0.18e-3,
                ..strip
            };
            films.extend([0.0, 5e-3].map(|length_m| Film {
                groove: Some(Groove { length_m, ..groove }),
                ..ridge
            }));
        }
    }
    films
}

#[test]
fn a_finer_grid_gives_the_same() {
    let films = films_of_all_kinds();
    let coarse = responses(&films, RECORDED);
    let fine = responses(&films, (96, 144));
    let mut carrier = Worst("carrier against a finer grid", 0.0);
    let mut mean = Worst(
        "mean against a finer grid, of the carrier's modulus times the ratio",
        0.0,
    );
    for (film, (coarse, fine)) in films.iter().zip(coarse.iter().zip(&fine)) {
        carrier.include((coarse.carrier / fine.carrier - 1.0).norm(), film);
        // The mean changes its sign over a leaking groove, so that its error is not compared with itself.
        let scale = fine.mean.abs().max(0.1 * film.ratio * fine.carrier.norm());
        mean.include((coarse.mean - fine.mean) / scale, film);
    }
    carrier.assert_below(0.003);
    mean.assert_below(0.003);
}

/// The film takes power from the plate at every squeeze number and amplitude.
#[test]
fn the_film_is_passive() {
    let films = films_of_all_kinds();
    for (film, response) in films.iter().zip(responses(&films, RECORDED)) {
        assert!(response.carrier.im > 0.0, "{film:?}: {response:?}");
        assert!(response.carrier.re > 0.0, "{film:?}: {response:?}");
    }
}

/// A groove that leaks through a short channel approaches one at ambient pressure; a long channel does not.
#[test]
fn a_short_groove_is_at_ambient_pressure() {
    let with_length = |length_m: f64| Film {
        half_width_m: 0.18e-3,
        groove: Some(Groove {
            half_width_m: 6e-5,
            depth_m: 6e-5,
            length_m,
        }),
        ..Film::new(Shape::Strip, 3.0, 0.5)
    };
    let films = [0.0, 1e-5, 5e-3].map(with_length);
    let [open, short, long] = responses(&films, RECORDED).try_into().unwrap();
    let away = |response: &Response| (response.carrier / open.carrier - 1.0).norm();
    assert!(away(&short) < 1e-3, "{short:?} {open:?}");
    assert!(away(&long) > 1e-2, "{long:?} {open:?}");
}
