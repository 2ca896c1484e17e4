/* Steady states of fingers over the amplitude of the plate, without a recording. SI units.
 *
 *     curve disc area_m2 half_width_m groove_half_width_m groove_depth_m groove_length_m disc_wavelength_m normal_n sigma_t_m
 *           asperity_pa loss_factor most_m points
 *
 * reads lines, each a finger on this film: skin_damping skin_reactance half_length_m wavelength_m. Writes for each `points` lines, or
 * fewer, and an empty one: amplitude_m gap_m film_n asperity_n relative_m re im. Lengths are those of world.c; re and im are the
 * finger's part of Z_m. A curve ends where the plate strikes the skin, or where the film lifts the finger off the table of gaps.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "finger.h"

static const double PI = 3.14159265358979323846;
enum { NUMBERS = 13, ITERATIONS = 1500 };
static struct contact contact;

int main(int count, char **given) {
    if (count != NUMBERS + 1) { fprintf(stderr, "usage: see curve.c\n"); return 2; }
    double value[NUMBERS];
    for (int i = 0; i < NUMBERS; i++) value[i] = atof(given[i + 1]);
    const int disc = value[0] > 0, points = (int)value[12];
    const double area_m2 = value[1], normal_n = value[7], most_m = value[11];
    contact.film = (struct film){
        .shape = disc ? DISC : STRIP, .half_width_m = disc ? sqrt(area_m2 / PI) : value[2], .omega = 2 * PI * 35e3,
        .ambient_pa = 101325, .viscosity_pa_s = 1.82e-5, .wavelength_m = value[6],
        .groove_half_width_m = value[3], .groove_depth_m = value[4], .groove_length_m = value[5],
        .cells = 40, .steps = 48,
    };
    contact.asperities = (struct asperities){.heights = EXPONENTIAL, .full_pa = value[9], .loss_factor = value[10]};
    const double rest_m = set_decay(&contact, value[8], normal_n / area_m2);
    contact.gaps = 36;
    contact.ratios = 18;
    contact.least_gap_m = 0.6 * rest_m;
    contact.most_gap_m = 15 * rest_m;
    if (fill(&contact)) { fprintf(stderr, "curve: no periodic state of the film\n"); return 3; }

    double damping, reactance, half_length_m, wavelength_m;
    while (scanf("%lf %lf %lf %lf", &damping, &reactance, &half_length_m, &wavelength_m) == 4) {
        const struct skin skin = {&contact, (damping + I * reactance) / area_m2, area_m2, 0.02};
        struct place places[PLACES];
        const int place_count = place_strips(half_length_m, wavelength_m, places);
        for (int i = 0; i < place_count; i++) {
            places[i].gap_m = rest_m;
            places[i].relative_m = 0;
        }
        for (int point = 1; point <= points; point++) {
            const double amplitude_m = most_m * point / points;
            struct finger finger = {0};
            for (int i = 0; i < ITERATIONS && !finger.strikes; i++) finger = advance(&skin, places, place_count, amplitude_m, normal_n);
            if (finger.strikes || finger.gap_m > 0.99 * contact.most_gap_m) break;
            printf("%.9g %.9g %.9g %.9g %.9g %.9g %.9g\n", amplitude_m, finger.gap_m, finger.film_n, finger.asperity_n,
                   finger.relative_m, creal(finger.impedance), cimag(finger.impedance));
        }
        printf("\n");
    }
    return 0;
}
