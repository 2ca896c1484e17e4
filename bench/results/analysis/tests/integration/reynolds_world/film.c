/* Equation of the film (Reynolds 1886; for an isothermal gas Langlois 1962), with p the pressure, h the gap, mu the viscosity:
 *
 *     d(p h)/dt = div( p h^3 / (12 mu) grad p )
 *
 * With X = x/L, P = p/p_a, H = h/g, theta = omega t and psi = (P - 1) H, the gas in excess of that at ambient pressure:
 *
 *     s (d(psi)/d(theta) + dH/d(theta)) = div( H^3 grad(P^2) / 2 ),     s = 12 mu omega L^2 / (p_a g^2), the squeeze number
 *
 * The finger's sliding would add a Couette term (6 mu V d(p h)/dx on the right); at 50 mm/s its bearing number
 * 6 mu V L / (p_a g^2) is 1e-3 for a ridge and 4e-2 for a fingertip against a squeeze number of 1 and 1000: left out.
 *
 * Space: finite volumes for psi, flux over a face from the difference of P^2. Cells shrink towards the edge as the
 * boundary layer does, whose thickness is L sqrt(2/s). Time: the L-stable diagonally implicit method of two stages and second order
 * (Alexander 1977), with steps that are shorter where the gap is small: theta = u - b sin u at equal steps of u. Period: Newton's
 * method for state(2 pi) = state(0), with the derivative of one by the other carried through all steps ("shooting").
 */
#include "film.h"

#include <math.h>
#include <string.h>

static const double TURN = 6.283185307179586;

double squeeze_number(const struct film *film, double gap_m) {
    const double per_gap = film->half_width_m / gap_m;
    return 12 * film->viscosity_pa_s * film->omega / film->ambient_pa * per_gap * per_gap;
}

static int groove_is_unknown(const struct film *film) {
    return film->groove_half_width_m > 0 && film->groove_length_m > 0;
}

/* Exponent b of the grid X = 1 - (exp(b (1 - u)) - 1)/(exp(b) - 1) whose last cell is `last` long. */
static double grading(int cells, double last) {
    double low = 0, high = 12;
    for (int i = 0; i < 60; i++) {
        const double b = 0.5 * (low + high);
        if (expm1(b / cells) / expm1(b) > last) low = b; else high = b;
    }
    return low;
}

/* The amplitude cos(2 pi y/wavelength) of the plate's mode, averaged over a circle around its crest: J0(2 pi r/wavelength). */
static double mode_at(const struct film *film, double x) {
    if (film->wavelength_m <= 0) return 1;
    return j0(TURN * x * film->half_width_m / film->wavelength_m);
}

void make_grid(const struct film *film, double gap_m, struct grid *grid) {
    const int n = film->cells;
    const double last = sqrt(2 / squeeze_number(film, gap_m)) * 6 / n;
    const double b = last < 1.0 / n ? grading(n, last) : 0;
    double edges[MOST_CELLS + 1];
    for (int i = 0; i <= n; i++) {
        const double u = (double)i / n;
        edges[i] = b > 1e-6 ? 1 - expm1(b * (1 - u)) / expm1(b) : u;
    }
    double middles[MOST_CELLS + 1];
    for (int i = 0; i < n; i++) {
        middles[i] = 0.5 * (edges[i] + edges[i + 1]);
        const double width = edges[i + 1] - edges[i];
        grid->volume[i] = film->shape == DISC ? middles[i] * width : width;
        grid->mode[i] = mode_at(film, middles[i]);
    }
    middles[n] = 1;
    for (int i = 0; i < n; i++) {
        const double edge = edges[i + 1];
        grid->face[i] = film->shape == DISC ? edge : 1;
        grid->distance[i] = middles[i + 1] - middles[i];
        grid->face_mode[i] = mode_at(film, edge);
    }
    grid->cells = n;
    grid->groove_volume = film->groove_half_width_m / film->half_width_m;
    grid->unknowns = n + groove_is_unknown(film);
}

/* A row i of the Jacobian: below[i], middle[i], above[i]. */
struct tridiagonal { double below[MOST_CELLS], middle[MOST_CELLS], above[MOST_CELLS]; };

struct problem {
    const struct film *film;
    struct grid grid;
    double gap_m, ratio, squeeze;
    double drift;   /* of sin(theta) over a period of the scheme, for exact mass: the closing of the gap adds up to zero */
};

/* Gap over its mean at a place with the amplitude `mode`; of the groove, whose bottom moves with the skin. */
static double opening(const struct problem *of, double mode, double theta) { return 1 - of->ratio * mode * cos(theta); }
static double groove_opening(const struct problem *of, double theta) {
    return of->film->groove_depth_m / of->gap_m + opening(of, 1, theta);
}

/* d(psi)/d(theta), and its Jacobian. A groove is one cell of uniform pressure, closed but for its ends. In a slit of depth D and half
 * length l that is filled along its length, the mean overpressure drives a flux of 3 w D^3 p/(12 mu l^2) per length (Poiseuille). */
static void rates(const struct problem *of, double theta, const double *psi, double *rate, struct tridiagonal *jacobian) {
    const struct grid *grid = &of->grid;
    const int n = grid->cells, unknowns = grid->unknowns;
    const double closing = -of->ratio * (sin(theta) - of->drift), swing = of->ratio * cos(theta);
    double squared[MOST_CELLS], slope[MOST_CELLS];
    for (int i = 0; i < unknowns; i++) {
        const double mode = i < n ? grid->mode[i] : 1;
        const double h = i < n ? 1 - swing * mode : groove_opening(of, theta);
        const double inverse = 1 / h, p = 1 + psi[i] * inverse;
        squared[i] = p * p;
        slope[i] = 2 * p * inverse;
        rate[i] = closing * mode;
        jacobian->below[i] = jacobian->middle[i] = jacobian->above[i] = 0;
    }
    for (int i = 0; i < n; i++) {
        const double h = 1 - swing * grid->face_mode[i], per_volume = 1 / grid->volume[i];
        const double conductance = grid->face[i] * h * h * h / (2 * grid->distance[i] * of->squeeze);
        const int has_next = i + 1 < unknowns;
        const double flux = conductance * (squared[i] - (has_next ? squared[i + 1] : 1));
        rate[i] -= flux * per_volume;
        jacobian->middle[i] -= conductance * slope[i] * per_volume;
        if (!has_next) continue;
        const double next_volume = i + 1 < n ? grid->volume[i + 1] : grid->groove_volume;
        rate[i + 1] += flux / next_volume;
        jacobian->above[i] = conductance * slope[i + 1] / grid->volume[i];
        jacobian->below[i + 1] = conductance * slope[i] / next_volume;
        jacobian->middle[i + 1] -= conductance * slope[i + 1] / next_volume;
    }
    if (unknowns > n) {
        const struct film *film = of->film;
        const double deep = film->groove_depth_m / of->gap_m;
        const double aspect = film->half_width_m / film->groove_length_m;
        const double leak = 3 * deep * deep * deep * aspect * aspect / (2 * of->squeeze);
        rate[n] -= leak * (squared[n] - 1);
        jacobian->middle[n] -= leak * slope[n];
    }
}

/* The matrix 1 - step * jacobian, factorised in place. */
static void factorise(struct tridiagonal *matrix, double step, int n) {
    for (int i = 0; i < n; i++) {
        matrix->below[i] *= -step;
        matrix->above[i] *= -step;
        matrix->middle[i] = 1 - step * matrix->middle[i];
        if (i > 0) {
            matrix->below[i] /= matrix->middle[i - 1];
            matrix->middle[i] -= matrix->below[i] * matrix->above[i - 1];
        }
    }
}

/* Solves for `columns` right-hand sides, row after row in `x`. */
static void substitute(const struct tridiagonal *matrix, int n, int columns, double *x) {
    for (int i = 1; i < n; i++) {
        const double below = matrix->below[i];
        for (int j = 0; j < columns; j++) x[i * columns + j] -= below * x[(i - 1) * columns + j];
    }
    for (int j = 0; j < columns; j++) x[(n - 1) * columns + j] /= matrix->middle[n - 1];
    for (int i = n - 2; i >= 0; i--) {
        const double above = matrix->above[i], inverse = 1 / matrix->middle[i];
        for (int j = 0; j < columns; j++) x[i * columns + j] = (x[i * columns + j] - above * x[(i + 1) * columns + j]) * inverse;
    }
}

/* Solves y = base + step * rate(y) by Newton's method; `y` begins as a guess. Leaves the factorised matrix of the last iteration. */
static int solve_stage(const struct problem *of, double theta, double step, const double *base, double *y, struct tridiagonal *matrix) {
    const int n = of->grid.unknowns;
    double rate[MOST_CELLS], change[MOST_CELLS];
    for (int iteration = 0; iteration < 12; iteration++) {
        double largest = 0;
        rates(of, theta, y, rate, matrix);
        factorise(matrix, step, n);
        for (int i = 0; i < n; i++) change[i] = base[i] + step * rate[i] - y[i];
        substitute(matrix, n, 1, change);
        for (int i = 0; i < n; i++) {
            y[i] += change[i];
            largest = fmax(largest, fabs(change[i]) / (1 + fabs(y[i])));
        }
        if (largest < 1e-10) return 0;
    }
    return 1;
}

static void add_pressures(const struct problem *of, double theta, const double *psi, double *mean, double *modal) {
    const struct grid *grid = &of->grid;
    double all = grid->groove_volume;
    *mean = *modal = 0;
    for (int i = 0; i < grid->cells; i++) {
        const double force = grid->volume[i] * psi[i] / opening(of, grid->mode[i], theta);
        all += grid->volume[i];
        *mean += force;
        *modal += force * grid->mode[i];
    }
    if (grid->unknowns > grid->cells) {
        const double force = grid->groove_volume * psi[grid->cells] / groove_opening(of, theta);
        *mean += force;
        *modal += force;
    }
    *mean /= all;
    *modal /= all;
}

/* Share of a step before its first stage, and contraction of the steps where the gap is small. */
static const double STAGE = 0.29289321881345254;
static double contraction(double ratio) { return 0.75 * ratio * ratio; }
static double time_at(int k, int steps, double ratio) {
    const double u = TURN * k / steps;
    return u - contraction(ratio) * sin(u);
}

static double sine_drift(int steps, double ratio) {
    double sum = 0;
    for (int k = 0; k < steps; k++) {
        const double theta = time_at(k, steps, ratio), next = time_at(k + 1, steps, ratio), step = next - theta;
        sum += step * ((1 - STAGE) * sin(theta + STAGE * step) + STAGE * sin(next));
    }
    return sum / TURN;
}

/* Follows `psi` through a period; `derivative` (rows of unknowns), if not null, becomes d psi(2 pi)/d psi(0). */
static int follow_period(const struct problem *of, double *psi, double *derivative, struct response *response) {
    const double g = STAGE;
    const int n = of->grid.unknowns, steps = of->film->steps;
    static double first[MOST_CELLS * MOST_CELLS];
    double base[MOST_CELLS], stage[MOST_CELLS], mean = 0;
    double complex carrier = 0;
    struct tridiagonal matrix;
    if (derivative) {
        memset(derivative, 0, sizeof(double) * (size_t)(n * n));
        for (int i = 0; i < n; i++) derivative[i * n + i] = 1;
    }
    for (int k = 0; k < steps; k++) {
        const double theta = time_at(k, steps, of->ratio), next = time_at(k + 1, steps, of->ratio), step = next - theta;
        memcpy(stage, psi, sizeof(double) * (size_t)n);
        if (solve_stage(of, theta + g * step, g * step, psi, stage, &matrix)) return 1;
        if (derivative) {
            memcpy(first, derivative, sizeof(double) * (size_t)(n * n));
            substitute(&matrix, n, n, first);
            for (int i = 0; i < n * n; i++) derivative[i] += (1 - g) / g * (first[i] - derivative[i]);
        }
        for (int i = 0; i < n; i++) base[i] = psi[i] + (1 - g) / g * (stage[i] - psi[i]);
        if (solve_stage(of, next, g * step, base, stage, &matrix)) return 1;
        if (derivative) substitute(&matrix, n, n, derivative);
        memcpy(psi, stage, sizeof(double) * (size_t)n);

        double pressure, modal;
        add_pressures(of, next, psi, &pressure, &modal);
        const double weight = (1 - contraction(of->ratio) * cos(TURN * (k + 1) / steps)) / steps;
        mean += weight * pressure;
        carrier += 2 * weight * modal * cexp(-I * next);
    }
    response->mean_pa = of->film->ambient_pa * mean;
    response->carrier_pa = of->film->ambient_pa * carrier;
    return 0;
}

/* Factorises a dense matrix with row exchanges, in place; then solves. */
static void factorise_dense(double *a, int n, int *order) {
    for (int k = 0; k < n; k++) {
        int best = k;
        for (int i = k + 1; i < n; i++)
            if (fabs(a[i * n + k]) > fabs(a[best * n + k])) best = i;
        order[k] = best;
        if (best != k)
            for (int j = 0; j < n; j++) {
                const double kept = a[k * n + j];
                a[k * n + j] = a[best * n + j];
                a[best * n + j] = kept;
            }
        for (int i = k + 1; i < n; i++) {
            const double factor = a[i * n + k] /= a[k * n + k];
            for (int j = k + 1; j < n; j++) a[i * n + j] -= factor * a[k * n + j];
        }
    }
}

static void substitute_dense(const double *a, int n, const int *order, double *x) {
    for (int k = 0; k < n; k++) {
        const double kept = x[k];
        x[k] = x[order[k]];
        x[order[k]] = kept;
    }
    for (int i = 1; i < n; i++)
        for (int j = 0; j < i; j++) x[i] -= a[i * n + j] * x[j];
    for (int i = n - 1; i >= 0; i--) {
        for (int j = i + 1; j < n; j++) x[i] -= a[i * n + j] * x[j];
        x[i] /= a[i * n + i];
    }
}

int solve_film(const struct film *film, double gap_m, double ratio, double *state, struct response *response) {
    struct problem of = {.film = film, .gap_m = gap_m, .ratio = ratio, .squeeze = squeeze_number(film, gap_m)};
    of.drift = sine_drift(film->steps, ratio);
    static double matrix[MOST_CELLS * MOST_CELLS];
    int order[MOST_CELLS], is_new = 0;
    double psi[MOST_CELLS] = {0}, residual[MOST_CELLS], before = INFINITY;
    make_grid(film, gap_m, &of.grid);
    const int n = of.grid.unknowns;
    for (int iteration = 0; iteration < 40; iteration++) {
        double size = 0;
        /* The matrix is made at first, and again if the last iteration did not gain a factor of 10. */
        const int make = iteration == 0 || (!is_new && iteration > 1) || iteration % 4 == 3;
        memcpy(psi, state, sizeof(double) * (size_t)n);
        if (follow_period(&of, psi, make ? matrix : NULL, response)) return 1;
        for (int i = 0; i < n; i++) {
            residual[i] = psi[i] - state[i];
            size = fmax(size, fabs(residual[i]) / (1 + fabs(state[i])));
        }
        if (size < 1e-10) return 0;
        is_new = size < 0.1 * before;
        before = size;
        if (make) {
            for (int i = 0; i < n * n; i++) matrix[i] = -matrix[i];
            for (int i = 0; i < n; i++) matrix[i * n + i] += 1;
            factorise_dense(matrix, n, order);
        }
        substitute_dense(matrix, n, order, residual);
        for (int i = 0; i < n; i++) state[i] += residual[i];
    }
    return 1;
}
