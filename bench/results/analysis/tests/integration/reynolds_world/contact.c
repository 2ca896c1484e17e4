#include "contact.h"

#include <math.h>

static const double PI = 3.14159265358979323846;
const double LARGEST_RATIO = 0.97;

/* Logarithm of the mean of (z - t)^(3/2) over normal z > t, but for -t^2/2 and a constant (Greenwood & Williamson 1966):
 * the integral of u^(3/2) exp(-t u - u^2/2), with u = v^2 so that it is smooth at 0. */
static double log_tail(double t) {
    const double end = sqrt(t > 0 ? fmin(9, 40 / (t + 1) + 1) : 9 - t);
    const int n = 400;
    double sum = 0;
    for (int i = 1; i < n; i++) {
        const double v = end * i / n, u = v * v;
        sum += (i % 2 ? 4 : 2) * 2 * u * u * exp(-t * u - u * u / 2);
    }
    return log(sum * end / n / 3) - t * t / 2;
}

/* The same, by cubic interpolation between nodes a tenth apart. */
static double log_gaussian(double t) {
    enum { NODES = 1300 };
    static double nodes[NODES];
    if (nodes[1] == 0)
        for (int i = 0; i < NODES; i++) nodes[i] = log_tail(0.1 * (i - 1));
    const double at = fmin(fmax(10 * t, 0), NODES - 4) + 1;
    const int i = (int)at;
    const double x = at - i, *y = nodes + i;
    return y[0] + x * (0.5 * (y[1] - y[-1]) + x * (y[-1] - 2.5 * y[0] + 2 * y[1] - 0.5 * y[2] + x * (1.5 * (y[0] - y[1]) + 0.5 * (y[2] - y[-1]))));
}

/* Pressure of asperities on the ridge, Pa. Exponential heights: p = p_0 exp(-h/l), whatever the law of one asperity (Greenwood &
 * Williamson 1966). Gaussian heights of standard deviation l: Hertz's law of one asperity over the tail above h. */
double asperity_pressure(const struct asperities *of, double gap_m) {
    if (of->heights == EXPONENTIAL) return of->full_pa * exp(-gap_m / of->decay_m);
    return of->full_pa * exp(log_gaussian(gap_m / of->decay_m) - log_gaussian(0));
}

static double ridge_share(const struct film *film) { return 1 / (1 + film->groove_half_width_m / film->half_width_m); }

double set_decay(struct contact *contact, double length_m, double pressure_pa) {
    struct asperities *asperities = &contact->asperities;
    const double logarithm = log(asperities->full_pa * ridge_share(&contact->film) / pressure_pa);
    if (asperities->heights == EXPONENTIAL) {
        asperities->decay_m = length_m;
        return length_m * logarithm;
    }
    double low = 0, high = 100;
    for (int i = 0; i < 60; i++) {
        const double t = 0.5 * (low + high);
        if (log_gaussian(0) - log_gaussian(t) < logarithm) low = t; else high = t;
    }
    asperities->decay_m = length_m * (log_gaussian(low - 0.01) - log_gaussian(low + 0.01)) / 0.02;
    return low * asperities->decay_m;
}

/* Mean over a period and component at the carrier of the asperities' pressure under a strip or disc whose amplitude has the mode's
 * shape. */
static void add_asperities(const struct contact *contact, double gap_m, double ratio, double *mean, double *carrier) {
    enum { PHASES = 96 };
    struct grid grid;
    double volume = 0;
    make_grid(&contact->film, gap_m, &grid);
    *mean = *carrier = 0;
    for (int i = 0; i < grid.cells; i++) {
        double cell_mean = 0, cell_carrier = 0;
        for (int k = 0; k < PHASES; k++) {
            const double cosine = cos(2 * PI * k / PHASES);
            const double p = asperity_pressure(&contact->asperities, gap_m * (1 - ratio * grid.mode[i] * cosine));
            cell_mean += p / PHASES;
            cell_carrier += 2 * p * cosine / PHASES;
        }
        *mean += grid.volume[i] * cell_mean;
        *carrier += grid.volume[i] * grid.mode[i] * cell_carrier;
        volume += grid.volume[i];
    }
    *mean *= ridge_share(&contact->film) / volume;
    *carrier *= ridge_share(&contact->film) / volume;
}

/* Nodes: gaps in geometric series, ratios of amplitude to gap closer together towards the largest. */
static double gap_of(const struct contact *contact, int i) {
    return contact->least_gap_m * pow(contact->most_gap_m / contact->least_gap_m, (double)i / (contact->gaps - 1));
}
static double ratio_of(const struct contact *contact, int j) {
    return j == 0 ? 0.02 : LARGEST_RATIO * sin(PI / 2 * j / (contact->ratios - 1));
}

int fill(struct contact *contact) {
    for (int i = 0; i < contact->gaps; i++) {
        double state[MOST_CELLS] = {0};
        for (int j = 0; j < contact->ratios; j++) {
            const double gap_m = gap_of(contact, i), ratio = ratio_of(contact, j);
            double mean, carrier;
            struct response film;
            if (solve_film(&contact->film, gap_m, ratio, state, &film)) return 1;
            add_asperities(contact, gap_m, ratio, &mean, &carrier);
            contact->nodes[i][j] = (struct node){
                .film_over_square = film.mean_pa / (ratio * ratio),
                .film_re = creal(film.carrier_pa) / ratio,
                .film_im = cimag(film.carrier_pa) / ratio,
                .asperity_log = log(mean),
                .asperity_over_ratio_log = log(carrier / ratio),
            };
        }
    }
    return 0;
}

/* Lagrange's weights of four neighbouring nodes at the place `at`, in units of their distance; returns the first. */
static int neighbours(double at, int count, double weights[4]) {
    const int first = (int)fmin(fmax(floor(at) - 1, 0), count - 4);
    const double x = at - first;
    weights[0] = -(x - 1) * (x - 2) * (x - 3) / 6;
    weights[1] = x * (x - 2) * (x - 3) / 2;
    weights[2] = -x * (x - 1) * (x - 3) / 2;
    weights[3] = x * (x - 1) * (x - 2) / 6;
    return first;
}

struct pressures pressures_at(const struct contact *contact, double gap_m, double amplitude_m) {
    const double ratio = fmin(amplitude_m / gap_m, LARGEST_RATIO);
    double by_gap[4], by_ratio[4];
    const int gap = neighbours(log(gap_m / contact->least_gap_m) / log(contact->most_gap_m / contact->least_gap_m) * (contact->gaps - 1),
                               contact->gaps, by_gap);
    const int first = neighbours(asin(ratio / LARGEST_RATIO) * 2 / PI * (contact->ratios - 1), contact->ratios, by_ratio);
    struct node sum = {0};
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            const struct node *node = &contact->nodes[gap + i][first + j];
            const double weight = by_gap[i] * by_ratio[j];
            sum.film_over_square += weight * node->film_over_square;
            sum.film_re += weight * node->film_re;
            sum.film_im += weight * node->film_im;
            sum.asperity_log += weight * node->asperity_log;
            sum.asperity_over_ratio_log += weight * node->asperity_over_ratio_log;
        }
    const double complex asperities = exp(sum.asperity_over_ratio_log) * (1 + I * contact->asperities.loss_factor);
    return (struct pressures){
        .film_pa = sum.film_over_square * ratio * ratio,
        .asperity_pa = exp(sum.asperity_log),
        .carrier_pa = ratio * (sum.film_re + I * sum.film_im + asperities),
    };
}

/* The skin, of impedance Z = d + i (omega m - k/omega) per area, is moved by the pressure alone: p = Z i omega y. The plate moves by
 * x = e + y, where e closes the gap. */
double complex plate_over_relative(const struct contact *contact, double complex skin, double gap_m, double amplitude_m) {
    const double complex pressure = pressures_at(contact, gap_m, amplitude_m).carrier_pa;
    return 1 + pressure / (I * contact->film.omega * skin * amplitude_m);
}

static double excess(const struct contact *contact, double complex skin, double plate_m, double gap_m, double amplitude_m) {
    return amplitude_m * cabs(plate_over_relative(contact, skin, gap_m, amplitude_m)) - plate_m;
}

double relative_amplitude(const struct contact *contact, double complex skin, double plate_m, double gap_m, double guess_m) {
    const double most_m = LARGEST_RATIO * gap_m, least_m = 1e-5 * gap_m, enough_m = 1e-9 * plate_m + 1e-16;
    double a = fmin(fmax(guess_m, least_m), most_m), fa = excess(contact, skin, plate_m, gap_m, a);
    double b = fmin(fmax(a * (1 - 0.5 * fa / plate_m), least_m), 0.999 * most_m);
    for (int i = 0; i < 8 && a != b; i++) {
        const double fb = excess(contact, skin, plate_m, gap_m, b);
        if (fabs(fb) < enough_m) return b;
        const double next = b - fb * (b - a) / (fb - fa);
        a = b;
        fa = fb;
        /* Only a root near the last is the same motion. */
        if (!(next > 0.8 * guess_m && next < 1.25 * guess_m && next < most_m)) break;
        b = next;
    }
    /* The smallest, which a plate that begins to move reaches first. */
    double low = least_m;
    if (excess(contact, skin, plate_m, gap_m, low) > 0) return low;
    for (int i = 1; i <= 60; i++) {
        double high = least_m + (most_m - least_m) * i / 60;
        if (excess(contact, skin, plate_m, gap_m, high) < 0) { low = high; continue; }
        for (int j = 0; j < 50; j++) {
            const double middle = 0.5 * (low + high);
            if (excess(contact, skin, plate_m, gap_m, middle) < 0) low = middle; else high = middle;
        }
        return 0.5 * (low + high);
    }
    return -1;
}
