/* A finger over the plate: places with a gap and an amplitude each. SI units. */
#ifndef FINGER_H
#define FINGER_H

#include "contact.h"

struct skin {
    const struct contact *contact;
    double complex z_per_area;
    double area_m2;
    double yielding;            /* share of the way to balance that the gap goes in a sample */
};

/* A part of the finger, with its share of the area and the plate's amplitude there relative to that of the pickup. */
struct place { double share, mode, gap_m, relative_m; };

enum { PLACES = 5 };

/* The one place of a disc, which has the mode within its film (film.c); returns the number of places. */
int place_disc(struct place *places);
/* Places along the strips of a finger of elliptical outline across the crest of the mode cos(2 pi y/wavelength), at most PLACES; one
 * if a length is 0, which means a uniform amplitude. Returns their number. */
int place_strips(double half_length_m, double wavelength_m, struct place *places);

/* Forces on the plate in a sample; `strikes` if the relative amplitude reaches the gap, beyond the table. */
struct finger { double complex impedance; double film_n, asperity_n, gap_m, relative_m; int strikes; };

struct finger advance(const struct skin *skin, struct place *places, int count, double plate_m, double normal_n);

#endif
