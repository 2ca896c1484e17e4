/* Slow motion of the gap. The skin behind the contact yields slowly: the gap closes what lacks to the balance of mean pressures
 * (film + asperities = applied pressure, Huloux et al. 2021, Eq. 13), at the stiffness of film and asperities, with a time constant. */
#include "finger.h"

#include <math.h>

static const double PI = 3.14159265358979323846;

int place_disc(struct place *places) {
    places[0] = (struct place){.share = 1, .mode = 1};
    return 1;
}

/* Gauss's rule for the weight sqrt(1 - y^2). */
int place_strips(double half_length_m, double wavelength_m, struct place *places) {
    if (half_length_m <= 0 || wavelength_m <= 0) return place_disc(places);
    double sum = 0;
    for (int i = 0; i < PLACES; i++) {
        const double angle = PI * (i + 1) / (2 * PLACES);       /* the other half of 2 PLACES - 1 nodes is its mirror image */
        places[i].share = pow(sin(angle), 2) * (i + 1 < PLACES ? 2 : 1);
        places[i].mode = cos(2 * PI * half_length_m * cos(angle) / wavelength_m);
        sum += places[i].share;
    }
    for (int i = 0; i < PLACES; i++) places[i].share /= sum;
    return PLACES;
}

struct finger advance(const struct skin *skin, struct place *places, int count, double plate_m, double normal_n) {
    const struct contact *contact = skin->contact;
    const double pressed_pa = normal_n / skin->area_m2;
    struct finger finger = {0};
    for (int i = 0; i < count; i++) {
        struct place *place = &places[i];
        const double g = place->gap_m, amplitude_m = fmax(fabs(place->mode) * plate_m, 1e-12);
        const double e = relative_amplitude(contact, skin->z_per_area, amplitude_m, g, place->relative_m);
        if (e < 0) {
            finger.strikes = 1;
            return finger;
        }
        place->relative_m = e;
        const struct pressures p = pressures_at(contact, g, e);
        const struct pressures wider = pressures_at(contact, 1.002 * g, e), narrower = pressures_at(contact, 0.998 * g, e);
        const double stiffness = (narrower.film_pa + narrower.asperity_pa - wider.film_pa - wider.asperity_pa) / (0.004 * g);
        const double lacking_m = (p.film_pa + p.asperity_pa - pressed_pa) / fmax(stiffness, 1e-3 * pressed_pa / g);
        place->gap_m += skin->yielding * fmin(fmax(lacking_m, -g / 2), g / 2);
        place->gap_m = fmin(fmax(place->gap_m, contact->least_gap_m), contact->most_gap_m);

        const double force_share = skin->area_m2 * place->share;
        finger.impedance += force_share * place->mode * place->mode * p.carrier_pa /
                            (I * contact->film.omega * e * plate_over_relative(contact, skin->z_per_area, g, e));
        finger.film_n += force_share * p.film_pa;
        finger.asperity_n += force_share * p.asperity_pa;
        finger.gap_m += place->share * place->gap_m;
        finger.relative_m += place->share * e;
    }
    return finger;
}
