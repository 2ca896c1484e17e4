/* Periodic state of a compressible isothermal gas film between a plate that vibrates and a skin above it. SI units. */
#ifndef FILM_H
#define FILM_H

#include <complex.h>

enum { MOST_CELLS = 260 };

enum shape { STRIP, DISC };

struct film {
    enum shape shape;
    double half_width_m;        /* of the strip; radius of the disc */
    double omega;               /* of the carrier, rad/s */
    double ambient_pa, viscosity_pa_s;
    double wavelength_m;        /* of the plate's mode, whose amplitude falls from the disc's centre; 0: uniform */
    double groove_half_width_m; /* beside a strip; 0: the strip's edge is at ambient pressure */
    double groove_depth_m;
    double groove_length_m;     /* from its middle to its open end; 0: the groove is at ambient pressure */
    int cells, steps;           /* across the half width, and in a period */
};

/* Cells across the half width, in parts of it: the last but one face is the strip's edge. */
struct grid {
    int cells, unknowns;
    double volume[MOST_CELLS], mode[MOST_CELLS];
    double face[MOST_CELLS], distance[MOST_CELLS], face_mode[MOST_CELLS];
    double groove_volume;       /* of the groove, whether it is an unknown or at ambient pressure */
};

/* Overpressure, mean over area (ridge and groove) and period, and its component at the carrier relative to the closing of the
 * gap: p = Re(carrier_pa exp(i omega t)) while the gap is gap (1 - ratio cos(omega t)). The carrier is weighted by the mode. */
struct response {
    double mean_pa;
    double complex carrier_pa;
};

double squeeze_number(const struct film *film, double gap_m);
void make_grid(const struct film *film, double gap_m, struct grid *grid);

/* Solves the periodic state. `state` has the unknowns where the gap is smallest: a guess, at first zeros, then the solution.
 * Returns 0, or 1 if it did not converge. */
int solve_film(const struct film *film, double gap_m, double ratio, double *state, struct response *response);

#endif
