//! Figures and numbers of docs/laws.md: Eqs. 14 to 18 of Huloux 2021 and their alternatives beside a film that obeys
//! Reynolds' equation.

mod drawn;
mod film_figures;
mod fitted;
mod impedance_figures;
mod law;
mod page;
mod reynolds_finger;
