//! Tests of the package on recordings of other simulations.

mod in_memory;
mod independent_world;
mod laws_in_doubt;
mod laws_page;
mod partial_recordings;
mod planted;
mod planted_in_people;
mod predictive;
mod reference_recordings;
mod reynolds_world;
mod verdict;
