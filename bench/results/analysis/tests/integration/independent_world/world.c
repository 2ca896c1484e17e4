/* A plate, a finger and a film in the time domain, from first principles: it shares no line and no number with the bench's
 * estimator or with its simulated apparatus. It writes a recording folder (docs/RECORDING.md) and the truth that made it.
 *
 *     world FOLDER name=value ...
 *
 * The names, with their defaults, are those of `numbers` below. SI units.
 *
 * Plate and skin are a mass on a spring and a mass with a dashpot, coupled by the contact's spring and dashpot. The contact is that of
 * Huloux et al. 2021: the gap follows the balance of forces (Eqs. 13 to 17) with a lag, and sets stiffness (18) and friction (19).
 * Four states by Runge and Kutta's fourth order at 2 MHz, 57 steps in a period of the carrier; the gap at 100 kHz.
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double PI = 3.14159265358979323846;
enum { RATE_HZ = 100000, STEPS = 20, END_MS = 3300, TOUCH_MS = 1200, BEGIN_MS = 1400, ARRIVE_MS = 3100 };

static struct { const char *name; double value; } numbers[] = {
    {"seed", 1},
    {"sigma_t_m", 1.7e-6}, {"re_z_t", 0.47}, {"im_z_t", 3.16},
    {"growth", 0},              /* of sigma_t and Im Z_t over the stroke, as a part */
    {"contact_area_m2", 300e-6}, {"area_force_exponent", 0}, {"q0_rad_per_m", 1.4e4}, {"loss_factor", 0.3},
    {"tau_s", 1e-3}, {"film_mean_s", 1e-4},
    {"mu0", 0.8}, {"floor", 0}, {"lateral_lag_s", 0},
    {"normal_n", 0.65}, {"tremor", 0.01},
    {"drift_hz", 0},            /* of the resonance from beginning to end */
    {"snr_db", 80}, {"pickup_phase_rad", 0},
};

static double is(const char *name) {
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        if (strcmp(numbers[i].name, name) == 0) return numbers[i].value;
    fprintf(stderr, "world: no number is called %s\n", name);
    exit(2);
}

static void take(char *given) {
    char *equals = strchr(given, '=');
    if (equals) *equals = 0;
    for (size_t i = 0; equals && i < sizeof numbers / sizeof *numbers; i++)
        if (strcmp(numbers[i].name, given) == 0) { numbers[i].value = atof(equals + 1); return; }
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

struct moving { double x, v, y, w; };   /* plate and skin: displacement and velocity */
struct forces { double volts, k, k_c, b_c, m_t, b_t; };
static const double PLATE_KG = 8e-3, DAMPING = 7.01, NEWTONS_PER_VOLT = 0.13;

static struct moving derivative(struct moving s, const struct forces *f) {
    double contact = f->k_c * (s.x - s.y) + f->b_c * (s.v - s.w);
    double plate = NEWTONS_PER_VOLT * f->volts - f->k * s.x - DAMPING * s.v - contact;
    return (struct moving){s.v, plate / PLATE_KG, s.w, (contact - f->b_t * s.w) / f->m_t};
}

static struct moving after(struct moving s, struct moving d, double h) {
    return (struct moving){s.x + h * d.x, s.v + h * d.v, s.y + h * d.y, s.w + h * d.w};
}

int main(int count, char **given) {
    if (count < 2) { fprintf(stderr, "usage: world FOLDER name=value ...\n"); return 2; }
    for (int i = 2; i < count; i++) take(given[i]);
    const char *folder = given[1];
    state = (uint64_t)is("seed");

    const double carrier_hz = 35010, omega = 2 * PI * carrier_hz, mean_v = 23, pascals = 101325, modulus = 20e6, poisson = 0.5;
    const double per_unit = 2e-6, phase = is("pickup_phase_rad"), h = 1.0 / RATE_HZ / STEPS;
    const double noise = pow(10, -is("snr_db") / 20);
    /* Root mean squares of what is recorded, by the drive's modulation of 95 %. */
    const double volts_rms = mean_v * sqrt(0.5 + 0.25 * 0.95 * 0.95);
    const double units_rms = NEWTONS_PER_VOLT * volts_rms / DAMPING / omega / per_unit;
    const double slow_turns = uniform(), tremor_turns = uniform(), wander_turns = uniform();

    FILE *wav = opened(folder, "signals.wav"), *force = opened(folder, "force.csv"), *position = opened(folder, "position.csv");
    FILE *truth = opened(folder, "truth.csv"), *manifest = opened(folder, "recording.toml");
    const uint32_t frames = (uint32_t)((uint64_t)END_MS * RATE_HZ / 1000);
    wav_header(wav, frames);
    fprintf(force, "time_s,normal_n,lateral_n\n");
    fprintf(position, "time_s,position_m\n");
    fprintf(truth, "time_s,sigma_t_m,re_z_t_n_s_per_m,im_z_t_n_s_per_m,resonance_hz,contact_area_m2,mu\n");

    struct moving s = {0};
    double gap = 0, squared = 0, lateral = 0;
    int touched = 0;
    for (uint32_t frame = 0; frame < frames; frame++) {
        const double t = (double)frame / RATE_HZ, ms = 1e3 * t;
        const double way = fmin(fmax((ms - BEGIN_MS) / (ARRIVE_MS - BEGIN_MS), 0), 1);
        const double sigma = is("sigma_t_m") * (1 + is("growth") * (way - 0.5));
        const double im_z_t = is("im_z_t") * (1 + is("growth") * (way - 0.5));
        const double resonance_hz = 35000 + is("drift_hz") * (t / (1e-3 * END_MS) - 0.5);
        const double rest = fmin(fmax((ms - TOUCH_MS) / 20, 0), 1);
        const double normal = rest * is("normal_n") *
            (1 + 0.05 * sin(2 * PI * (0.7 * t + slow_turns)) + 0.02 * sin(2 * PI * (2.3 * t + wander_turns)) +
             is("tremor") * sin(2 * PI * (9.1 * t + tremor_turns)));

        struct forces f = {.k = PLATE_KG * pow(2 * PI * resonance_hz, 2), .m_t = im_z_t / omega, .b_t = is("re_z_t")};
        double mu = 0;
        const double heavier = normal / is("normal_n");
        const double area = is("contact_area_m2") * pow(fmax(heavier, 1e-6), is("area_force_exponent"));
        squared += (s.x * s.x + s.v * s.v / (omega * omega) - squared) * (1 - exp(-1.0 / RATE_HZ / is("film_mean_s")));
        if (normal > 1e-3) {
            const double p_c = 0.375 * is("q0_rad_per_m") * sigma * modulus / (1 - poisson * poisson);
            const double at_rest = sigma * log(p_c * area / normal), film = 1.25 * pascals * area * squared;
            double low = at_rest, high = at_rest + 2e-4;
            for (int i = 0; i < 40; i++) {
                const double middle = 0.5 * (low + high);
                const double lacking = normal * (1 - exp((at_rest - middle) / sigma)) - film / (middle * middle);
                if (lacking > 0) high = middle; else low = middle;
            }
            const double balanced = 0.5 * (low + high);
            gap = touched ? gap + (balanced - gap) * (1 - exp(-1.0 / RATE_HZ / is("tau_s"))) : balanced;
            touched = 1;
            const double asperities = p_c * area * exp(-gap / sigma);
            f.k_c = asperities / sigma + 2 * film / (gap * gap * gap);
            f.b_c = is("loss_factor") * f.k_c / omega;
            mu = is("mu0") * (is("floor") + (1 - is("floor")) * exp((at_rest - gap) / sigma));
        }
        const double slides = way > 0 && way < 1 ? 1 : 0;
        const double pulls = slides * mu * normal;
        lateral = is("lateral_lag_s") > 0 ? lateral + (pulls - lateral) * (1 - exp(-1.0 / RATE_HZ / is("lateral_lag_s"))) : pulls;

        const double envelope = mean_v * (1 + 0.95 * sin(2 * PI * 6 * (t - 0.04)));
        const float sample[2] = {
            (float)(envelope * cos(omega * t) + noise * volts_rms * gauss()),
            (float)((s.x * cos(phase) - s.v / omega * sin(phase)) / per_unit + noise * units_rms * gauss()),
        };
        fwrite(sample, sizeof sample, 1, wav);
        if (frame % 10 == 0)
            fprintf(force, "%.4f,%.6f,%.6f\n", t, normal + 1e-3 * gauss(), lateral + 4e-3 * gauss());
        if (frame % 100 == 0) {
            fprintf(position, "%.3f,%.6f\n", t, 0.01 + 0.085 * way);
            fprintf(truth, "%.3f,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g\n", t, sigma, is("re_z_t"), im_z_t, resonance_hz, area, mu);
        }
        for (int step = 0; step < STEPS; step++) {
            const double at = t + step * h;
            const double modulated = mean_v * (1 + 0.95 * sin(2 * PI * 6 * (at - 0.04)));
            f.volts = modulated * cos(omega * at);
            struct moving a = derivative(s, &f);
            f.volts = modulated * cos(omega * (at + h / 2));
            struct moving b = derivative(after(s, a, h / 2), &f), c = derivative(after(s, b, h / 2), &f);
            f.volts = modulated * cos(omega * (at + h));
            struct moving d = derivative(after(s, c, h), &f);
            s.x += h / 6 * (a.x + 2 * b.x + 2 * c.x + d.x);
            s.v += h / 6 * (a.v + 2 * b.v + 2 * c.v + d.v);
            s.y += h / 6 * (a.y + 2 * b.y + 2 * c.y + d.y);
            s.w += h / 6 * (a.w + 2 * b.w + 2 * c.w + d.w);
        }
        /* A skin without a plate comes to rest. */
        if (!f.k_c) s.y = s.w = 0;
    }
    fprintf(manifest,
            "format = 1\ncarrier_hz = %.1f\nmodulation_hz = 6.0\nmodulation_index = 0.95\n\n"
            "[channels.drive]\nindex = 0\nvolts_per_unit = 1.0\n\n"
            "[channels.pickup]\nindex = 1\nmetres_per_unit = %g\nphase_rad = %g\n\n"
            "[plate]\nresonance_hz = 35000.0\nmodal_mass_kg = %g\nforce_factor_n_per_v = %g\ncentre_m = 0.0525\n\n"
            "[[intervals]]\nkind = \"unloaded\"\nstart_s = 0.2\nend_s = 1.0\n\n"
            "[[intervals]]\nkind = \"exploration\"\ndirection = \"left_to_right\"\nstart_s = %g\nend_s = %g\n",
            carrier_hz, per_unit, phase, PLATE_KG, NEWTONS_PER_VOLT, 1e-3 * BEGIN_MS, 1e-3 * ARRIVE_MS);
    FILE *all[] = {wav, force, position, truth, manifest};
    for (int i = 0; i < 5; i++)
        if (fclose(all[i])) { perror(folder); return 2; }
    return 0;
}
