/* Pressure between plate and skin, from the gas film and from the skin's asperities, over gap and relative amplitude; and the motion
 * of a skin under it. SI units. */
#ifndef CONTACT_H
#define CONTACT_H

#include "film.h"

enum heights { EXPONENTIAL, GAUSSIAN };

struct asperities {
    enum heights heights;
    double full_pa;             /* pressure at zero gap */
    double decay_m;             /* exponential: decay length; Gaussian: standard deviation of heights */
    double loss_factor;
};

enum { MOST_GAPS = 120, MOST_RATIOS = 40 };

/* Means over the apparent area, grooves included, and components at the carrier, in each node. */
struct node { double film_over_square, asperity_log, film_re, film_im, asperity_over_ratio_log; };

struct contact {
    struct film film;
    struct asperities asperities;
    int gaps, ratios;
    double least_gap_m, most_gap_m;
    struct node nodes[MOST_GAPS][MOST_RATIOS];
};

/* Pressures on the plate: means, and carrier relative to the closing of the gap. */
struct pressures { double film_pa, asperity_pa; double complex carrier_pa; };

extern const double LARGEST_RATIO;

/* Pressure of asperities on the ridge at a gap. */
double asperity_pressure(const struct asperities *asperities, double gap_m);
/* Sets the decay of the asperities so that it is `length_m` at rest under `pressure_pa` on the apparent area; returns the gap there. */
double set_decay(struct contact *contact, double length_m, double pressure_pa);
/* Fills the table; returns 0, or 1 if the film has no solution in a node. */
int fill(struct contact *contact);
struct pressures pressures_at(const struct contact *contact, double gap_m, double amplitude_m);

/* Solves the relative amplitude under a plate of amplitude `plate_m` for a skin of impedance `skin` per area. `guess_m` is that of
 * the sample before. Returns a negative number if there is none up to the largest ratio. */
double relative_amplitude(const struct contact *contact, double complex skin, double plate_m, double gap_m, double guess_m);
/* Plate's displacement over the relative one. */
double complex plate_over_relative(const struct contact *contact, double complex skin, double gap_m, double amplitude_m);

#endif
