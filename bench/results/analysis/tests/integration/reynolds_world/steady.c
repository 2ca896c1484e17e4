/* The steady state of a finger on a plate of constant amplitude, in two ways: by the tables and the slow motion of the recording's
 * world, and by integrating film, skin and gap through every cycle, on a uniform grid with explicit steps, without separation of
 * scales, harmonics or tables; only the gap's slow yielding follows the mean pressure of the cycle before. SI units.
 *
 *     steady shape(0 strip, 1 disc) half_width_m plate_m load_pa sigma_t_m asperity_pa skin_kg skin_damping skin_n_per_m cells cycles
 *         ->   two lines: gap_m film_pa asperity_pa re im, the last the pressure at the carrier over the plate's velocity
 *
 * Mass, damping and stiffness of the skin are for a square metre; heights are exponential, without loss.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "finger.h"

static const double PI = 3.14159265358979323846;
enum { NODES = 200 };
static struct contact contact;
static double plate_m, load_pa, skin_kg, skin_damping, skin_n_per_m;

static void print_state(double gap_m, double film_pa, double asperity_pa, double complex z) {
    printf("%.9g %.9g %.9g %.9g %.9g\n", gap_m, film_pa, asperity_pa, creal(z), cimag(z));
}

static int by_tables(double rest_m) {
    const double omega = contact.film.omega;
    const double complex z = skin_damping + I * (omega * skin_kg - skin_n_per_m / omega);
    const struct skin skin = {&contact, z, 1, 0.02};
    struct place place = {1, 1, rest_m, 0};
    struct finger finger = {0};
    contact.gaps = 36;
    contact.ratios = 18;
    contact.least_gap_m = 0.6 * rest_m;
    contact.most_gap_m = 15 * rest_m;
    if (fill(&contact)) return 1;
    for (int i = 0; i < 4000; i++) {
        finger = advance(&skin, &place, 1, plate_m * fmin(i / 1500.0, 1), load_pa);
        if (finger.strikes) return 1;
    }
    print_state(finger.gap_m, finger.film_n, finger.asperity_n, finger.impedance);
    return 0;
}

/* Mass of gas per area over its density at ambient pressure, in each cell; skin's displacement and velocity; slow gap. */
struct moving { double mass[NODES], y, w, gap; };
struct loads { double film_pa, asperity_pa; };

static struct loads slopes(const struct moving *s, double x, double yields_m_per_s, struct moving *slope) {
    const struct film *film = &contact.film;
    const int n = film->cells, disc = film->shape == DISC;
    const double h = s->gap + s->y - x, length = film->half_width_m / n;
    const double conductance = film->ambient_pa * h * h * h / (12 * film->viscosity_pa_s);
    double flux = 0, force = 0, area = 0;
    for (int i = 0; i < n; i++) {
        const double p = s->mass[i] / h, next = i + 1 < n ? s->mass[i + 1] / h : 1;
        const double face = disc ? (i + 1.0) / n : 1, volume = disc ? (i + 0.5) / n : 1;
        const double distance = i + 1 < n ? length : length / 2;
        const double out = face * conductance * (p * p - next * next) / (2 * distance);
        slope->mass[i] = (flux - out) / (volume * length);
        flux = out;
        force += volume * (p - 1);
        area += volume;
    }
    const struct loads loads = {film->ambient_pa * force / area, asperity_pressure(&contact.asperities, h)};
    const double excess_pa = loads.film_pa + loads.asperity_pa - load_pa;
    slope->y = s->w;
    slope->w = (excess_pa - skin_damping * s->w - skin_n_per_m * s->y) / skin_kg;
    slope->gap = yields_m_per_s;
    return loads;
}

static void add(struct moving *s, const struct moving *slope, double step, int cells) {
    for (int i = 0; i < cells; i++) s->mass[i] += step * slope->mass[i];
    s->y += step * slope->y;
    s->w += step * slope->w;
    s->gap += step * slope->gap;
}

/* Midpoint rule, with steps a third of the limit of stability of the smallest gas spring. Averages over the last tenth of the cycles. */
static int in_time(double rest_m, int cycles) {
    const struct film *film = &contact.film;
    const int n = film->cells, averaged = cycles / 10;
    const double omega = film->omega, length = film->half_width_m / n;
    static struct moving s, slope, middle;
    struct loads sum = {0, 0};
    double complex carrier = 0;
    double gap = 0;
    const double rate = contact.asperities.decay_m / load_pa / 0.5e-3;
    double lacking_pa = 0;
    for (int i = 0; i < n; i++) s.mass[i] = rest_m;
    s.gap = rest_m;
    for (int cycle = 0; cycle < cycles; cycle++) {
        const double ramped = plate_m * fmin(2.5 * cycle / cycles, 1);
        const double widest = 2 * s.gap, diffusivity = film->ambient_pa * widest * widest / (12 * film->viscosity_pa_s);
        const int steps = (int)fmax(200, ceil(2 * PI / omega * 6 * diffusivity / (length * length)));
        const double step = 2 * PI / omega / steps, yields_m_per_s = rate * lacking_pa;
        lacking_pa = 0;
        for (int k = 0; k < steps; k++) {
            const double angle = 2 * PI * k / steps, half = angle + PI / steps;
            slopes(&s, ramped * cos(angle), yields_m_per_s, &slope);
            middle = s;
            add(&middle, &slope, step / 2, n);
            const struct loads loads = slopes(&middle, ramped * cos(half), yields_m_per_s, &slope);
            add(&s, &slope, step, n);
            lacking_pa += (loads.film_pa + loads.asperity_pa - load_pa) / steps;
            if (!(s.gap + s.y - ramped * cos(angle) > 0)) return 1;
            if (cycle < cycles - averaged) continue;
            const double weight = 1.0 / steps / averaged;
            sum.film_pa += weight * loads.film_pa;
            sum.asperity_pa += weight * loads.asperity_pa;
            gap += weight * middle.gap + weight * middle.y;
            carrier += 2 * weight * (loads.film_pa + loads.asperity_pa) * cexp(-I * half);
        }
    }
    print_state(gap, sum.film_pa, sum.asperity_pa, carrier / (I * omega * plate_m));
    return 0;
}

int main(int count, char **given) {
    if (count != 12) { fprintf(stderr, "usage: see steady.c\n"); return 2; }
    double value[12];
    for (int i = 1; i < 12; i++) value[i] = atof(given[i]);
    contact.film = (struct film){
        .shape = value[1] > 0 ? DISC : STRIP, .half_width_m = value[2], .omega = 2 * PI * 35e3,
        .ambient_pa = 101325, .viscosity_pa_s = 1.82e-5, .cells = 40, .steps = 48,
    };
    plate_m = value[3];
    load_pa = value[4];
    contact.asperities = (struct asperities){.heights = EXPONENTIAL, .full_pa = value[6]};
    const double rest_m = set_decay(&contact, value[5], load_pa);
    skin_kg = value[7];
    skin_damping = value[8];
    skin_n_per_m = value[9];
    if (by_tables(rest_m)) { fprintf(stderr, "steady: no steady state by the tables\n"); return 3; }
    contact.film.cells = (int)fmin(value[10], NODES);
    if (in_time(rest_m, (int)value[11])) { fprintf(stderr, "steady: the skin strikes the plate\n"); return 3; }
    return 0;
}
