/* A plate, a finger and a film in the time domain: an independent implementation of the laws that the bench's estimator
 * assumes. It shares no line and no number with the estimator or with the simulated apparatus. The numbers below `laws`
 * each replace one law by another; with their defaults the published laws hold. It writes a recording folder
 * (docs/RECORDING.md) and the truth that made it.
 *
 *     world FOLDER name=value ...
 *
 * The names, with their defaults, are those of `numbers` below. SI units.
 *
 * Plate and skin are a mass on a spring and a mass with a dashpot, coupled by the contact's spring and dashpot. The contact is that of
 * Huloux et al. 2021: the gap follows the balance of forces (Eqs. 13 to 17) with a lag, and sets stiffness (18) and friction (19).
 * Six states by Runge and Kutta's fourth order at 2 MHz, 57 steps in a period of the carrier; the gap at 100 kHz.
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double PI = 3.14159265358979323846;
enum { RATE_HZ = 100000, STEPS = 20, END_MS = 3300, TOUCH_MS = 1200, BEGIN_MS = 1400, ARRIVE_MS = 3100 };

#define NUMBERS(X) \
    X(seed, 1) \
    X(sigma_t_m, 1.7e-6) X(re_z_t, 0.47) X(im_z_t, 3.16) \
    X(growth, 0)                 /* of sigma_t and Im Z_t over the stroke, relative */ \
    X(contact_area_m2, 300e-6) X(area_force_exponent, 0) X(q0_rad_per_m, 1.4e4) X(loss_factor, 0.3) \
    X(tau_s, 1e-3) X(film_mean_s, 1e-4) \
    X(mu0, 0.8) X(floor, 0) X(lateral_lag_s, 0) \
    X(normal_n, 0.65) X(tremor, 0.01) \
    X(drift_hz, 0)               /* of the resonance from beginning to end */ \
    X(snr_db, 80) X(pickup_phase_rad, 0) \
    X(drive_v, 23)               /* mean over the modulation, peak at the actuators */ \
    X(modulation_hz, 6) \
    X(resonance_hz, 35000)       /* the carrier is 10 Hz above */ \
    X(after_s, 0)                /* duration of the recording after the finger has left */ \
    /* laws: the plate's mode across its width; the finger's outline is an ellipse, or a strip of constant length */ \
    X(wavelength_across_m, 0)    /* 0: uniform */ \
    X(finger_width_m, 0) X(finger_is_strip, 0) \
    X(finger_offset_m, 0)        /* of its middle from the antinode */ \
    X(stated_wavelength_m, 0)    /* in recording.toml, with a standard error of 1 %; 0: not stated */ \
    /* laws: the film */ \
    X(trapped_air, 0)            /* share of the carrier's stiffness that is p0 S/x; the rest is 2 f_s/x */ \
    X(film_loss, 0)              /* its loss factor minus the asperities' */ \
    X(relative_motion, 0)        /* share of the skin's motion that is subtracted from the plate's */ \
    X(ambient_pa, 101325) X(states_pressure, 0) \
    /* laws: Eq. 15 averaged over the carrier's cycle */ \
    X(cycle_average, 0)          /* its share, in force and stiffness */ \
    X(cycle_harmonic, 0)         /* 1: the stiffness is that of the force's first harmonic instead */ \
    /* laws: the plate */ \
    X(softening_ppm_per_um2, 0)  /* fall of its resonance by the square of its amplitude */ \
    X(second_mode_hz, 0)         /* its resonance; 0: no second mode */ \
    X(second_mode_kg, 0.02) X(second_mode_damping, 17) \
    X(second_mode_at_drive, 1) X(second_mode_at_pickup, 1) X(second_mode_at_finger, 1) \
    /* laws: the force sensor */ \
    X(normal_zero_n, 0) X(normal_zero_n_per_s, 0) X(lateral_zero_n, 0) X(lateral_zero_n_per_s, 0) \
    X(normal_to_lateral, 0) X(lateral_to_normal, 0) \
    X(normal_lag_s, 0)           /* time constant of a first-order lag */ \
    X(forces_late_s, 0)          /* delay of both axes */

#define FIELD(name, value) double name;
#define DEFAULT(name, value) .name = value,
#define NAMED(name, value) {#name, &is.name},
static struct { NUMBERS(FIELD) } is = { NUMBERS(DEFAULT) };
static const struct { const char *name; double *value; } numbers[] = { NUMBERS(NAMED) };

static void take(char *given) {
    char *equals = strchr(given, '=');
    if (equals) *equals = 0;
    for (size_t i = 0; equals && i < sizeof numbers / sizeof *numbers; i++)
        if (strcmp(numbers[i].name, given) == 0) { *numbers[i].value = atof(equals + 1); return; }
    fprintf(stderr, "world: %s is no name=value of its numbers\n", given);
    exit(2);
}

/* Steele, Lea and Flood 2014; then Box and Muller. */
static uint64_t state;
static double uniform(void) {
    uint64_t z = (state += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return ((double)((z ^ (z >> 31)) >> 11) + 0.5) * 0x1p-53;
}
static double gauss(void) { return sqrt(-2 * log(uniform())) * cos(2 * PI * uniform()); }

static FILE *opened(const char *folder, const char *name) {
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "wb");
    if (!file) { perror(path); exit(2); }
    return file;
}

/* 32-bit float, on a machine whose bytes stand as those of the file do. */
static void wav_header(FILE *wav, uint32_t frames) {
    uint32_t bytes = frames * 8, riff = bytes + 36, sixteen = 16, rate = RATE_HZ, per_second = RATE_HZ * 8;
    uint16_t floats = 3, channels = 2, per_frame = 8, bits = 32;
    fwrite("RIFF", 4, 1, wav); fwrite(&riff, 4, 1, wav); fwrite("WAVEfmt ", 8, 1, wav); fwrite(&sixteen, 4, 1, wav);
    fwrite(&floats, 2, 1, wav); fwrite(&channels, 2, 1, wav); fwrite(&rate, 4, 1, wav); fwrite(&per_second, 4, 1, wav);
    fwrite(&per_frame, 2, 1, wav); fwrite(&bits, 2, 1, wav); fwrite("data", 4, 1, wav); fwrite(&bytes, 4, 1, wav);
}

/* Displacement and velocity of the plate's mode at its antinode, of the skin, and of the plate's second mode. */
struct moving { double x, v, y, w, z, u; };
/* Contact of strips with stiffness k_i, damping b_i and mode m_i: k = sum k_i, k_mode = sum m_i k_i/k, and
 * k_rest = sum m_i^2 k_i - k k_mode^2, which acts on the plate alone; b likewise. */
struct forces { double k_plate, k, k_mode, k_rest, b, b_mode, b_rest, per_m_t, b_t, cubic, second_k, per_second_kg; };
static const double PLATE_KG = 8e-3, DAMPING = 7.01, NEWTONS_PER_VOLT = 0.13;

static struct moving derivative(struct moving s, const struct forces *f, double volts) {
    const double x = s.x + is.second_mode_at_finger * s.z, v = s.v + is.second_mode_at_finger * s.u;
    const double spring = f->k * (f->k_mode * x - s.y), dashpot = f->b * (f->b_mode * v - s.w);
    const double contact = (f->k_mode * spring + f->k_rest * x) + (f->b_mode * dashpot + f->b_rest * v);
    const double plate = NEWTONS_PER_VOLT * volts - f->k_plate * s.x * (1 - f->cubic * s.x * s.x) - DAMPING * s.v - contact;
    double second = 0;
    if (f->second_k > 0)
        second = is.second_mode_at_drive * NEWTONS_PER_VOLT * volts - f->second_k * s.z - is.second_mode_damping * s.u -
            is.second_mode_at_finger * contact;
    return (struct moving){s.v, plate * (1 / PLATE_KG), s.w, (spring + dashpot - f->b_t * s.w) * f->per_m_t, s.u,
                           second * f->per_second_kg};
}

static struct moving after(struct moving s, struct moving d, double h) {
    return (struct moving){s.x + h * d.x, s.v + h * d.v, s.y + h * d.y, s.w + h * d.w, s.z + h * d.z, s.u + h * d.u};
}

/* Part of the contact across the plate: share of the area, amplitude of the mode, and mean square of the motion that
 * drives the film. */
struct strip { double share, mode, squared; };
enum { MOST_STRIPS = 32, PHASES = 12 };

/* Divides the contact; the ellipse at angles evenly spaced, by which its integral converges fast. */
static int divide(struct strip *strips) {
    if (is.wavelength_across_m <= 0) { strips[0] = (struct strip){1, 1, 0}; return 1; }
    double sum = 0;
    for (int i = 0; i < MOST_STRIPS; i++) {
        const double part = (i + 0.5) / MOST_STRIPS, angle = PI * (part - 0.5);
        const double place = 0.5 * is.finger_width_m * (is.finger_is_strip > 0 ? 2 * part - 1 : sin(angle));
        strips[i].share = is.finger_is_strip > 0 ? 1 : pow(cos(angle), 2);
        strips[i].mode = cos(2 * PI * (place + is.finger_offset_m) / is.wavelength_across_m);
        strips[i].squared = 0;
        sum += strips[i].share;
    }
    for (int i = 0; i < MOST_STRIPS; i++) strips[i].share /= sum;
    return MOST_STRIPS;
}

/* Factors by which the cycle's average of exp(-a cos(phase)/sigma) raises the asperities' force and stiffness. */
static void raised(double relative, double *force, double *stiffness) {
    double mean = 0, first = 0;
    for (int i = 0; i < PHASES && is.cycle_average > 0; i++) {
        const double cosine = cos(PI * (i + 0.5) / PHASES), pressure = exp(-relative * cosine);
        mean += pressure / PHASES;
        first -= 2 * cosine * pressure / PHASES;
    }
    *force = *stiffness = 1;
    if (is.cycle_average <= 0) return;
    *force += is.cycle_average * (mean - 1);
    const double harmonic = relative > 1e-6 ? first / relative : 1;
    *stiffness += is.cycle_average * ((is.cycle_harmonic > 0 ? harmonic : mean) - 1);
}

/* Readings of a sensor, every frame; the value read at a time that lies between two is on the line between them. */
static double late(const double *readings, uint32_t frame) {
    const double at = fmax(frame - is.forces_late_s * RATE_HZ, 0), part = at - floor(at);
    const uint32_t before = (uint32_t)at;
    return part > 0 ? readings[before] + part * (readings[before + 1] - readings[before]) : readings[before];
}

int main(int count, char **given) {
    if (count < 2) { fprintf(stderr, "usage: world FOLDER name=value ...\n"); return 2; }
    for (int i = 2; i < count; i++) take(given[i]);
    const char *folder = given[1];
    state = (uint64_t)is.seed;

    const double carrier_hz = is.resonance_hz + 10, omega = 2 * PI * carrier_hz, mean_v = is.drive_v, modulus = 20e6, poisson = 0.5;
    const double pascals = is.ambient_pa, per_unit = 2e-6, phase = is.pickup_phase_rad, h = 1.0 / RATE_HZ / STEPS;
    const double noise = pow(10, -is.snr_db / 20), half_cosine = cos(omega * h / 2), half_sine = sin(omega * h / 2);
    /* Root mean squares of what is recorded, by the drive's modulation of 95 %. */
    const double volts_rms = mean_v * sqrt(0.5 + 0.25 * 0.95 * 0.95);
    const double units_rms = NEWTONS_PER_VOLT * volts_rms / DAMPING / omega / per_unit;
    const double slow_turns = uniform(), tremor_turns = uniform(), wander_turns = uniform();

    FILE *wav = opened(folder, "signals.wav"), *force = opened(folder, "force.csv"), *position = opened(folder, "position.csv");
    FILE *truth = opened(folder, "truth.csv"), *manifest = opened(folder, "recording.toml");
    const uint32_t frames = (uint32_t)((uint64_t)END_MS * RATE_HZ / 1000) + (uint32_t)lround(is.after_s * RATE_HZ);
    double *normals = calloc(frames, sizeof *normals), *laterals = calloc(frames, sizeof *laterals);
    if (!normals || !laterals) { perror("world"); return 2; }
    wav_header(wav, frames);
    fprintf(force, "time_s,normal_n,lateral_n\n");
    fprintf(position, "time_s,position_m\n");
    fprintf(truth, "time_s,sigma_t_m,re_z_t_n_s_per_m,im_z_t_n_s_per_m,resonance_hz,contact_area_m2,mu\n");

    struct moving s = {0};
    struct strip strips[MOST_STRIPS];
    const int used = divide(strips);
    double gap = 0, lateral = 0, normal_read = 0;
    int touched = 0;
    for (uint32_t frame = 0; frame < frames; frame++) {
        const double t = (double)frame / RATE_HZ, ms = 1e3 * t;
        const double way = fmin(fmax((ms - BEGIN_MS) / (ARRIVE_MS - BEGIN_MS), 0), 1);
        const double sigma = is.sigma_t_m * (1 + is.growth * (way - 0.5));
        const double im_z_t = is.im_z_t * (1 + is.growth * (way - 0.5));
        const double resonance_hz = is.resonance_hz + is.drift_hz * (t / (1e-3 * END_MS) - 0.5);
        const double rest = fmin(fmax((ms - TOUCH_MS) / 20, 0), 1) * fmin(fmax(1 - (ms - END_MS) / 20, 0), 1);
        const double normal = rest * is.normal_n *
            (1 + 0.05 * sin(2 * PI * (0.7 * t + slow_turns)) + 0.02 * sin(2 * PI * (2.3 * t + wander_turns)) +
             is.tremor * sin(2 * PI * (9.1 * t + tremor_turns)));

        struct forces f = {.k_plate = PLATE_KG * pow(2 * PI * resonance_hz, 2), .per_m_t = omega / im_z_t, .b_t = is.re_z_t,
                           .k_mode = 1, .b_mode = 1, .per_second_kg = 1 / is.second_mode_kg,
                           .second_k = is.second_mode_kg * pow(2 * PI * is.second_mode_hz, 2),
                           /* A spring k(1 - c x^2) lowers the resonance by 3/8 c a^2, relative. */
                           .cubic = 8.0 / 3 * 1e6 * is.softening_ppm_per_um2};
        double mu = 0;
        const double heavier = normal / is.normal_n;
        const double area = is.contact_area_m2 * pow(fmax(heavier, 1e-6), is.area_force_exponent);
        const double x = s.x + is.second_mode_at_finger * s.z, v = s.v + is.second_mode_at_finger * s.u;
        const double renewed = 1 - exp(-1.0 / RATE_HZ / is.film_mean_s);
        for (int i = 0; i < used; i++) {
            const double moved = strips[i].mode * x - is.relative_motion * s.y;
            const double speed = strips[i].mode * v - is.relative_motion * s.w;
            strips[i].squared += (moved * moved + speed * speed / (omega * omega) - strips[i].squared) * renewed;
        }
        if (normal > 1e-3) {
            const double p_c = 0.375 * is.q0_rad_per_m * sigma * modulus / (1 - poisson * poisson);
            double squared = 0, lifts = 0, stiffness[MOST_STRIPS];
            for (int i = 0; i < used; i++) {
                double force;
                raised(sqrt(strips[i].squared) / sigma, &force, &stiffness[i]);
                squared += strips[i].share * strips[i].squared;
                lifts += strips[i].share * force;
            }
            const double at_rest = sigma * log(p_c * area / normal), film = 1.25 * pascals * area * squared;
            double low = at_rest, high = at_rest + 2e-4;
            for (int i = 0; i < 40; i++) {
                const double middle = 0.5 * (low + high);
                const double lacking = normal * (1 - lifts * exp((at_rest - middle) / sigma)) - film / (middle * middle);
                if (lacking > 0) high = middle; else low = middle;
            }
            const double balanced = 0.5 * (low + high);
            gap = touched ? gap + (balanced - gap) * (1 - exp(-1.0 / RATE_HZ / is.tau_s)) : balanced;
            touched = 1;
            const double asperities = p_c * area * exp(-gap / sigma);
            double k_1 = 0, k_2 = 0, b_1 = 0, b_2 = 0;
            for (int i = 0; i < used; i++) {
                const double share = strips[i].share, mode = strips[i].mode;
                const double film_of_strip = 1.25 * pascals * area * share * strips[i].squared;
                const double film_k = (1 - is.trapped_air) * (2 * film_of_strip / (gap * gap * gap)) +
                    is.trapped_air * pascals * area * share / gap;
                const double k = share * stiffness[i] * asperities / sigma + film_k;
                const double b = (is.loss_factor * k + is.film_loss * film_k) / omega;
                f.k += k; k_1 += mode * k; k_2 += mode * mode * k;
                f.b += b; b_1 += mode * b; b_2 += mode * mode * b;
            }
            f.k_mode = k_1 / f.k; f.k_rest = k_2 - f.k * f.k_mode * f.k_mode;
            f.b_mode = b_1 / f.b; f.b_rest = b_2 - f.b * f.b_mode * f.b_mode;
            mu = is.mu0 * (is.floor + (1 - is.floor) * lifts * exp((at_rest - gap) / sigma));
        }
        const double slides = way > 0 && way < 1 ? 1 : 0;
        const double pulls = slides * mu * normal;
        const double pulls_read = pulls + is.normal_to_lateral * normal, presses_read = normal + is.lateral_to_normal * pulls;
        lateral = is.lateral_lag_s > 0 ?
            lateral + (pulls_read - lateral) * (1 - exp(-1.0 / RATE_HZ / is.lateral_lag_s)) : pulls_read;
        normal_read = is.normal_lag_s > 0 ?
            normal_read + (presses_read - normal_read) * (1 - exp(-1.0 / RATE_HZ / is.normal_lag_s)) : presses_read;
        normals[frame] = normal_read + is.normal_zero_n + is.normal_zero_n_per_s * t;
        laterals[frame] = lateral + is.lateral_zero_n + is.lateral_zero_n_per_s * t;

        const double envelope = mean_v * (1 + 0.95 * sin(2 * PI * is.modulation_hz * (t - 0.04)));
        const double seen = s.x + is.second_mode_at_pickup * s.z, seen_speed = s.v + is.second_mode_at_pickup * s.u;
        const float sample[2] = {
            (float)(envelope * cos(omega * t) + noise * volts_rms * gauss()),
            (float)((seen * cos(phase) - seen_speed / omega * sin(phase)) / per_unit + noise * units_rms * gauss()),
        };
        fwrite(sample, sizeof sample, 1, wav);
        if (frame % 10 == 0)
            fprintf(force, "%.4f,%.6f,%.6f\n", t, late(normals, frame) + 1e-3 * gauss(), late(laterals, frame) + 4e-3 * gauss());
        if (frame % 100 == 0) {
            fprintf(position, "%.3f,%.6f\n", t, 0.01 + 0.085 * way);
            fprintf(truth, "%.3f,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g\n", t, sigma, is.re_z_t, im_z_t, resonance_hz, area, mu);
        }
        /* The frame's envelope is close to a line: its second difference is 1e-9 of it. */
        const double grows = mean_v * (1 + 0.95 * sin(2 * PI * is.modulation_hz * (t + STEPS * h - 0.04))) - envelope;
        double cosine = cos(omega * t), sine = sin(omega * t), halves[2 * STEPS + 1];
        for (int half = 0; half <= 2 * STEPS; half++) {
            halves[half] = (envelope + grows * half / (2 * STEPS)) * cosine;
            const double turned = cosine * half_cosine - sine * half_sine;
            sine = sine * half_cosine + cosine * half_sine;
            cosine = turned;
        }
        for (int step = 0; step < STEPS; step++) {
            const double *volts = halves + 2 * step;
            struct moving a = derivative(s, &f, volts[0]);
            struct moving b = derivative(after(s, a, h / 2), &f, volts[1]), c = derivative(after(s, b, h / 2), &f, volts[1]);
            struct moving d = derivative(after(s, c, h), &f, volts[2]);
            s.x += h / 6 * (a.x + 2 * b.x + 2 * c.x + d.x);
            s.v += h / 6 * (a.v + 2 * b.v + 2 * c.v + d.v);
            s.y += h / 6 * (a.y + 2 * b.y + 2 * c.y + d.y);
            s.w += h / 6 * (a.w + 2 * b.w + 2 * c.w + d.w);
            s.z += h / 6 * (a.z + 2 * b.z + 2 * c.z + d.z);
            s.u += h / 6 * (a.u + 2 * b.u + 2 * c.u + d.u);
        }
        /* A skin without a plate comes to rest. */
        if (!f.k) s.y = s.w = 0;
    }
    fprintf(manifest,
            "format = 1\ncarrier_hz = %.1f\nmodulation_hz = %.1f\nmodulation_index = 0.95\n\n"
            "[channels.drive]\nindex = 0\nvolts_per_unit = 1.0\n\n"
            "[channels.pickup]\nindex = 1\nmetres_per_unit = %g\nphase_rad = %g\n\n"
            "[plate]\nresonance_hz = %.1f\nmodal_mass_kg = %g\nforce_factor_n_per_v = %g\ncentre_m = 0.0525\n",
            carrier_hz, is.modulation_hz, per_unit, phase, is.resonance_hz, PLATE_KG, NEWTONS_PER_VOLT);
    if (is.stated_wavelength_m > 0)
        fprintf(manifest, "\n[plate.across]\nwavelength_m = %g\nstandard_error_m = %g\nsource = \"measured\"\n",
                is.stated_wavelength_m, 0.01 * is.stated_wavelength_m);
    if (is.states_pressure > 0) fprintf(manifest, "\n[room]\npressure_hpa = %g\n", pascals / 100);
    fprintf(manifest,
            "\n[[intervals]]\nkind = \"unloaded\"\nstart_s = 0.2\nend_s = 1.0\n\n"
            "[[intervals]]\nkind = \"exploration\"\ndirection = \"left_to_right\"\nstart_s = %g\nend_s = %g\n",
            1e-3 * BEGIN_MS, 1e-3 * ARRIVE_MS);
    if (is.after_s > 0.6)
        fprintf(manifest, "\n[[intervals]]\nkind = \"unloaded\"\nstart_s = %g\nend_s = %g\n", 1e-3 * END_MS + 0.3,
                1e-3 * END_MS + is.after_s - 0.1);
    free(normals);
    free(laterals);
    FILE *all[] = {wav, force, position, truth, manifest};
    for (int i = 0; i < 5; i++)
        if (fclose(all[i])) { perror(folder); return 2; }
    return 0;
}
