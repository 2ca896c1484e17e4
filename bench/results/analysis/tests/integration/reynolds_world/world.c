/* A ridged, striped or round fingertip on a vibrating plate, over a film of gas from first principles (README.md). Writes a recording
 * folder (docs/RECORDING.md) and the truth that made it.
 *
 *     world FOLDER name=value ...
 *
 * The names, with their defaults, are those of `numbers` below. SI units.
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "finger.h"

static const double PI = 3.14159265358979323846;
enum { RATE_HZ = 100000, END_MS = 3300, TOUCH_MS = 1200, BEGIN_MS = 1400, ARRIVE_MS = 3100 };

static struct { const char *name; double value; } numbers[] = {
    {"seed", 1},
    {"disc", 0},                    /* 0: strips, 1: a disc */
    {"contact_area_m2", 200e-6},    /* apparent, grooves included; sets a disc's radius */
    {"half_width_m", 0.2e-3},       /* of a strip */
    {"groove_half_width_m", 0},     /* 0: strips side by side, vented between them */
    {"groove_depth_m", 60e-6}, {"groove_length_m", 0},
    {"half_length_m", 0},           /* of the finger across the plate, along the strips; 0: uniform amplitude */
    {"wavelength_m", 0},            /* of the plate's mode; 0: uniform amplitude */
    {"gaussian", 0},                /* heights of asperities: 0 exponential, 1 Gaussian */
    {"sigma_t_m", 1.7e-6},          /* decay of their pressure with the gap, at rest under the nominal force */
    {"asperity_pa", 240e3},         /* their pressure at zero gap */
    {"loss_factor", 0.3},
    {"skin_damping", 0.47},         /* Z_t = damping + i (omega mass - stiffness/omega) */
    {"skin_kg", 17e-6}, {"skin_n_per_m", 127e3},
    {"tau_s", 1e-3},
    {"mu0", 0.8},
    {"normal_n", 0.65}, {"tremor", 0.01},
    {"mean_v", 23}, {"drift_hz", 0}, {"snr_db", 80}, {"pickup_phase_rad", 0},
    {"ambient_pa", 101325}, {"viscosity_pa_s", 1.82e-5},
    {"cells", 40}, {"steps", 48}, {"gaps", 36}, {"ratios", 18},
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

/* xorshift64* (Vigna 2016), and a sum of twelve uniform numbers for a normal one, by pairs of 32 bits. */
static uint64_t state;
static uint64_t random_bits(void) {
    state ^= state >> 12;
    state ^= state << 25;
    state ^= state >> 27;
    return state * 0x2545f4914f6cdd1du;
}
static double uniform(void) { return (double)(random_bits() >> 11) * 0x1p-53; }
static double gauss(void) {
    double sum = -6;
    for (int i = 0; i < 6; i++) {
        const uint64_t bits = random_bits();
        sum += (double)(bits >> 32) * 0x1p-32 + (double)(bits & 0xffffffffu) * 0x1p-32;
    }
    return sum;
}

static FILE *opened(const char *folder, const char *name) {
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "wb");
    if (!file) { perror(path); exit(2); }
    return file;
}

static void little_endian(FILE *file, uint32_t value, int bytes) {
    for (int i = 0; i < bytes; i++) fputc((int)(value >> 8 * i & 0xff), file);
}

/* Two channels of 32-bit float, in the byte order of this machine, which must be that of the file. */
static void wav_header(FILE *wav, uint32_t frames) {
    const uint32_t frame = 2 * sizeof(float), bytes = frames * frame;
    fputs("RIFF", wav); little_endian(wav, 36 + bytes, 4); fputs("WAVEfmt ", wav); little_endian(wav, 16, 4);
    little_endian(wav, 3, 2); little_endian(wav, 2, 2); little_endian(wav, RATE_HZ, 4); little_endian(wav, RATE_HZ * frame, 4);
    little_endian(wav, frame, 2); little_endian(wav, 32, 2); fputs("data", wav); little_endian(wav, bytes, 4);
}

static struct contact contact;

static void describe(double omega, double nominal_pa) {
    const int disc = is("disc") != 0;
    contact.film = (struct film){
        .shape = disc ? DISC : STRIP,
        .half_width_m = disc ? sqrt(is("contact_area_m2") / PI) : is("half_width_m"),
        .omega = omega,
        .ambient_pa = is("ambient_pa"), .viscosity_pa_s = is("viscosity_pa_s"),
        .wavelength_m = disc ? is("wavelength_m") : 0,
        .groove_half_width_m = disc ? 0 : is("groove_half_width_m"),
        .groove_depth_m = is("groove_depth_m"), .groove_length_m = is("groove_length_m"),
        .cells = (int)is("cells"), .steps = (int)is("steps"),
    };
    contact.asperities = (struct asperities){
        .heights = is("gaussian") ? GAUSSIAN : EXPONENTIAL,
        .full_pa = is("asperity_pa"), .loss_factor = is("loss_factor"),
    };
    contact.gaps = (int)is("gaps");
    contact.ratios = (int)is("ratios");
    const double rest_m = set_decay(&contact, is("sigma_t_m"), nominal_pa);
    contact.least_gap_m = 0.6 * rest_m;
    contact.most_gap_m = 15 * rest_m;
}

int main(int count, char **given) {
    if (count < 2) { fprintf(stderr, "usage: world FOLDER name=value ...\n"); return 2; }
    for (int i = 2; i < count; i++) take(given[i]);
    const char *folder = given[1];
    state = 0x9e3779b97f4a7c15u * ((uint64_t)is("seed") + 1);
    for (int i = 0; i < 20; i++) random_bits();

    const double plate_kg = 8e-3, damping = 7.01, newtons_per_volt = 0.13, resonance_hz = 35000;
    const double carrier_hz = 35000, omega = 2 * PI * carrier_hz, step = 1.0 / RATE_HZ, per_unit = 2e-6;
    const double area_m2 = is("contact_area_m2"), phase = is("pickup_phase_rad"), mean_v = is("mean_v");
    const double nominal_n = is("normal_n"), tremor = is("tremor"), mu0 = is("mu0"), drift_hz = is("drift_hz");
    const double complex z_t = is("skin_damping") + I * (omega * is("skin_kg") - is("skin_n_per_m") / omega);
    const struct skin skin = {&contact, z_t / area_m2, area_m2, 1 - exp(-1.0 / RATE_HZ / is("tau_s"))};
    struct place places[PLACES];
    const int place_count = is("disc") ? place_disc(places) : place_strips(is("half_length_m"), is("wavelength_m"), places);
    describe(omega, nominal_n / area_m2);
    if (fill(&contact)) { fprintf(stderr, "world: no periodic state of the film\n"); return 3; }
    for (int i = 0; i < place_count; i++) places[i].gap_m = contact.most_gap_m;

    const double noise = pow(10, -is("snr_db") / 20);
    const double volts_rms = mean_v * sqrt(0.5 + 0.25 * 0.95 * 0.95);
    const double units_rms = newtons_per_volt * volts_rms / damping / omega / per_unit;
    const double slow_turns = uniform(), tremor_turns = uniform(), wander_turns = uniform();

    FILE *wav = opened(folder, "signals.wav"), *force = opened(folder, "force.csv"), *position = opened(folder, "position.csv");
    FILE *truth = opened(folder, "truth.csv"), *manifest = opened(folder, "recording.toml");
    const uint32_t frames = (uint32_t)((uint64_t)END_MS * RATE_HZ / 1000);
    wav_header(wav, frames);
    fprintf(force, "time_s,normal_n,lateral_n\n");
    fprintf(position, "time_s,position_m\n");
    fprintf(truth, "time_s,sigma_t_m,re_z_t_n_s_per_m,im_z_t_n_s_per_m,resonance_hz,contact_area_m2,mu,gap_m,film_n,asperity_n,"
                   "amplitude_m,relative_m,re_contact_n_s_per_m,im_contact_n_s_per_m\n");

    double complex x = 0;
    for (uint32_t frame = 0; frame < frames; frame++) {
        const double t = (double)frame / RATE_HZ, ms = 1e3 * t;
        const double way = fmin(fmax((ms - BEGIN_MS) / (ARRIVE_MS - BEGIN_MS), 0), 1);
        const double shifted_hz = resonance_hz + drift_hz * (t / (1e-3 * END_MS) - 0.5);
        const double normal = fmin(fmax((ms - TOUCH_MS) / 20, 0), 1) * nominal_n *
            (1 + 0.05 * sin(2 * PI * (0.7 * t + slow_turns)) + 0.02 * sin(2 * PI * (2.3 * t + wander_turns)) +
             tremor * sin(2 * PI * (9.1 * t + tremor_turns)));
        struct finger finger = {0};
        double mu = 0;
        if (normal > 1e-3) {
            finger = advance(&skin, places, place_count, cabs(x), normal);
            mu = mu0 * finger.asperity_n / normal;
        }
        if (finger.strikes) {
            fprintf(stderr, "world: the skin strikes the plate at %g s\n", t);
            return 3;
        }
        const int slides = way > 0 && way < 1;
        if (slides && finger.gap_m > 0.99 * contact.most_gap_m) {
            fprintf(stderr, "world: the film lifts the finger off the table of gaps\n");
            return 3;
        }

        const double envelope = mean_v * (1 + 0.95 * sin(2 * PI * 6 * (t - 0.04)));
        const double complex turning = cexp(I * omega * t);
        const float sample[2] = {
            (float)(envelope * creal(turning) + noise * volts_rms * gauss()),
            (float)(creal(x * turning * cexp(-I * phase)) / per_unit + noise * units_rms * gauss()),
        };
        fwrite(sample, sizeof sample, 1, wav);
        if (frame % 10 == 0)
            fprintf(force, "%.4f,%.6f,%.6f\n", t, normal + 1e-3 * gauss(), slides * mu * normal + 4e-3 * gauss());
        if (frame % 100 == 0) {
            fprintf(position, "%.3f,%.6f\n", t, 0.01 + 0.085 * way);
            fprintf(truth, "%.3f,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g\n", t, is("sigma_t_m"), creal(z_t),
                    cimag(z_t), shifted_hz, area_m2, mu, finger.gap_m, finger.film_n, finger.asperity_n, cabs(x), finger.relative_m,
                    creal(finger.impedance), cimag(finger.impedance));
        }
        /* m x'' + b x' + k x = f - F for x = Re(X exp(i omega t)), where X'' is (2 pi 6/omega)^2 = 3e-8 of omega^2 X and left out:
         * (2 i omega m + b) X' = F_a - (k - omega^2 m + i omega (b + Z)) X, exact over a sample with Z and the drive held. */
        const double stiffness = plate_kg * pow(2 * PI * shifted_hz, 2);
        const double complex inertia = 2 * I * omega * plate_kg + damping;
        const double complex restoring = stiffness - omega * omega * plate_kg + I * omega * (damping + finger.impedance);
        const double driven_n = newtons_per_volt * mean_v * (1 + 0.95 * sin(2 * PI * 6 * (t + step / 2 - 0.04)));
        const double complex towards = driven_n / restoring;
        x = towards + (x - towards) * cexp(-restoring / inertia * step);
    }
    fprintf(manifest,
            "format = 1\ncarrier_hz = %.1f\nmodulation_hz = 6.0\nmodulation_index = 0.95\n\n"
            "[channels.drive]\nindex = 0\nvolts_per_unit = 1.0\n\n"
            "[channels.pickup]\nindex = 1\nmetres_per_unit = %g\nphase_rad = %g\n\n"
            "[plate]\nresonance_hz = %.1f\nmodal_mass_kg = %g\nforce_factor_n_per_v = %g\ncentre_m = 0.0525\n\n"
            "[[intervals]]\nkind = \"unloaded\"\nstart_s = 0.2\nend_s = 1.0\n\n"
            "[[intervals]]\nkind = \"exploration\"\ndirection = \"left_to_right\"\nstart_s = %g\nend_s = %g\n",
            carrier_hz, per_unit, phase, resonance_hz, plate_kg, newtons_per_volt, 1e-3 * BEGIN_MS, 1e-3 * ARRIVE_MS);
    FILE *all[] = {wav, force, position, truth, manifest};
    for (int i = 0; i < 5; i++)
        if (fclose(all[i])) { perror(folder); return 2; }
    return 0;
}
