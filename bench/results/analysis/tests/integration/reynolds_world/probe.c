/* Periodic states of the film for checks: reads lines of numbers, writes a line of answers for each.
 *
 *     shape(0 strip, 1 disc) cells steps half_width_m gap_m ratio omega viscosity ambient_pa wavelength_m
 *         groove_half_width_m groove_depth_m groove_length_m   ->   squeeze_number mean_pa carrier_re_pa carrier_im_pa
 */
#include <stdio.h>

#include "film.h"

int main(void) {
    struct film film;
    int shape;
    double gap_m, ratio;
    while (scanf("%d %d %d %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf", &shape, &film.cells, &film.steps, &film.half_width_m, &gap_m, &ratio,
                 &film.omega, &film.viscosity_pa_s, &film.ambient_pa, &film.wavelength_m, &film.groove_half_width_m,
                 &film.groove_depth_m, &film.groove_length_m) == 13) {
        double state[MOST_CELLS] = {0};
        struct response response;
        film.shape = shape ? DISC : STRIP;
        /* Towards the amplitude in steps, so that the guess is always near. */
        for (int part = 1; part <= 4; part++)
            if (solve_film(&film, gap_m, ratio * part / 4, state, &response)) {
                fprintf(stderr, "probe: no periodic state at %g m, ratio %g\n", gap_m, ratio * part / 4);
                return 3;
            }
        printf("%.12g %.12g %.12g %.12g\n", squeeze_number(&film, gap_m), response.mean_pa, creal(response.carrier_pa),
               cimag(response.carrier_pa));
    }
    return 0;
}
