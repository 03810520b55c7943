/* Integration: DOP853 of Hairer, Norsett and Wanner with dense output, and events inside steps. */
#include <string.h>
#include "lumped.h"
#include "dop853.h"

enum { STAGES = 12, ALL_STAGES = 16, COLUMNS = 7, SAMPLES = 5, LOCATING = 40 };
enum { STORM = 200, MOST_STEPS = 10000000 };
static const double FINEST = 1e-3; /* part of a step down to which a margin is searched for a dip */

/* A step with its dense output. */
typedef struct {
    double t, h, before[N_STATES + 1], after[N_STATES + 1], dense[COLUMNS][N_STATES + 1];
    double m[N_MODES + N_GUESSES + 1];
} Step;

static void at(const Step *step, double fraction, double *x)
{
    for (int i = 0; i < N_STATES; i++) {
        double y = 0.0;
        for (int k = 0; k < COLUMNS; k++)
            y = (y + step->dense[COLUMNS - 1 - k][i]) * (k % 2 ? 1 - fraction : fraction);
        x[i] = fraction == 1.0 ? step->after[i] : step->before[i] + y;
    }
}

static void rates_at(const Run *run, const double *x, double t, const double *m, double *f)
{
    model_rates(x, run->p, &t, m, f);
}

/* x + h * sum of weighted stages */
static void combined(const double *x, double h, double k[][N_STATES + 1], const double *weights,
                     int count, double *result)
{
    for (int i = 0; i < N_STATES; i++) {
        double sum = 0.0;
        for (int j = 0; j < count; j++) sum += weights[j] * k[j][i];
        result[i] = (x ? x[i] : 0.0) + h * sum;
    }
}

/* ---- where margins are used up ------------------------------------------------------------ */

static void sample(const Run *run, const Step *step, double low, double width,
                   double z[SAMPLES][N_MARGINS + 1])
{
    double x[N_STATES + 1];
    for (int j = 0; j < SAMPLES; j++) {
        double fraction = low + 0.25 * j * width;
        at(step, fraction, x);
        indicators(run, x, step->t + fraction * step->h, step->m, z[j]);
    }
}

/* Derivative of the margins by the fraction of a part of a step. */
static void slope_at(const Run *run, const Step *step, double fraction, double width, double *slope)
{
    double x[N_STATES + 1], t = step->t + fraction * step->h;
    at(step, fraction, x);
    model_margin_rates(x, run->p, &t, step->m, slope);
    for (int i = 0; i < N_MARGINS; i++) slope[i] *= width * step->h;
}

/* Whether a margin may have been below zero between its samples.

   Between samples it dips by an eighth of its second difference at most, if it is smooth. It is
   not resolved if its fourth difference is not small, or if the samples contradict its slopes. */
static bool doubtful(const double y[SAMPLES], double first, double last)
{
    static const double weights[SAMPLES] = {-25.0 / 12, 4, -3, 4.0 / 3, -0.25}; /* Fornberg 1988 */
    double least = y[0], most = y[0], falls = fmin(first, last), climbs = fmax(first, last);
    double rise[4], bend[3], sampled[2] = {0, 0};
    for (int j = 0; j < SAMPLES; j++) {
        least = fmin(least, y[j]);
        most = fmax(most, y[j]);
        sampled[0] += weights[j] * y[j];
        sampled[1] -= weights[j] * y[SAMPLES - 1 - j];
    }
    for (int j = 0; j < 4; j++) {
        rise[j] = y[j + 1] - y[j];
        falls = fmin(falls, rise[j]);
        climbs = fmax(climbs, rise[j]);
    }
    for (int j = 0; j < 3; j++) bend[j] = rise[j + 1] - rise[j];
    double largest = fmax(fmax(fabs(bend[0]), fabs(bend[1])), fabs(bend[2]));
    double rough = fabs(bend[0] - 2 * bend[1] + bend[2]);
    rough = fmax(rough, fabs(0.25 * first - sampled[0]));
    rough = fmax(rough, fabs(0.25 * last - sampled[1]));
    bool dips = falls * climbs < 0 && least < largest / 8;
    return dips || (rough > 0.2 * (most - least) && least < rough);
}

/* Fractions of a step between which a margin first falls below zero, and all that do there. */
static bool first_below(const Run *run, const Step *step, double low, double width, double *from,
                        double *to, bool *fallen)
{
    double z[SAMPLES][N_MARGINS + 1], first[N_MARGINS + 1], last[N_MARGINS + 1];
    int end = 0;
    bool doubt = false;
    sample(run, step, low, width, z);
    slope_at(run, step, low, width, first);
    slope_at(run, step, low + width, width, last);
    for (int j = 1; j < SAMPLES && !end; j++)
        for (int i = 0; i < N_MARGINS; i++)
            if (z[j][i] < 0) end = j;
    for (int i = 0; i < N_MARGINS && width > FINEST; i++) {
        double y[SAMPLES];
        for (int j = 0; j < SAMPLES; j++) y[j] = z[j][i];
        doubt |= doubtful(y, first[i], last[i]);
    }
    for (int half = 0; half < 2 && doubt; half++) {
        double begin = low + 0.5 * half * width;
        if (end && low + 0.25 * (end - 1) * width <= begin) break;
        if (first_below(run, step, begin, 0.5 * width, from, to, fallen)) return true;
    }
    if (!end) return false;
    for (int i = 0; i < N_MARGINS; i++) fallen[i] = z[end][i] < 0;
    *from = low + 0.25 * (end - 1) * width;
    *to = low + 0.25 * end * width;
    return true;
}

/* One margin at a fraction of a step, with so many of its tolerances. */
static double margin_at(const Run *run, const Step *step, double fraction, int margin, double extra)
{
    double x[N_STATES + 1], z[N_MARGINS + 1], tolerances[N_MARGINS + 1];
    double t = step->t + fraction * step->h;
    at(step, fraction, x);
    model_margins(x, run->p, &t, step->m, z, tolerances);
    return z[margin] + extra * tolerances[margin];
}

/* Where a margin falls to zero: Illinois variant of the secant method (Dowell and Jarratt, BIT 11
   (1971) 168); or a little before the first fraction, if it is negative there already. */
static double located(const Run *run, const Step *step, double a, double b, int margin, double extra)
{
    double fa = margin_at(run, step, a, margin, extra), fb = margin_at(run, step, b, margin, extra);
    for (int i = 0; i < LOCATING && fb != 0 && fabs(a - b) > 0x1p-53; i++) {
        double c = fa == fb ? b : (a * fb - b * fa) / (fb - fa);
        double fc = margin_at(run, step, c, margin, extra);
        if (fc * fb < 0) {
            a = b;
            fa = fb;
        } else {
            fa *= 0.5;
        }
        b = c;
        fb = fc;
    }
    return fb <= 0 ? b : a;
}

/* Where a margin that is zero when the step begins is positive before it falls again. */
static double risen(const Run *run, const Step *step, int margin, double end)
{
    for (int power = 1; power < 30; power++) {
        double fraction = ldexp(end, -power);
        if (margin_at(run, step, fraction, margin, 0.0) > 0) return fraction;
    }
    return 0.0;
}

/* The first instant in a step at which a margin is used up; fraction, and what fires there. */
static bool first_crossing(const Run *run, const Step *step, double *fraction, bool *fired)
{
    double low = 0.0, high = 1.0, x[N_STATES + 1], z[N_MARGINS + 1], tolerances[N_MARGINS + 1];
    bool suspects[N_MARGINS + 1] = {false};
    int margin = 0, sharing = 0;
    if (!first_below(run, step, 0.0, 1.0, &low, &high, suspects)) return false;
    while (!suspects[margin]) margin++;
    for (int next = margin; next >= 0;) {
        margin = next;
        double begin = low > 0 ? low : risen(run, step, margin, high);
        double found = located(run, step, begin, high, margin, 0.0);
        if (!(begin - FINEST <= found && found <= high)) /* zero within its tolerance till now */
            found = located(run, step, begin, high, margin, 1.0);
        high = fmax(found, 0.0);
        at(step, high, x);
        double t = step->t + high * step->h;
        model_margins(x, run->p, &t, step->m, z, tolerances);
        next = -1;
        for (int i = N_MARGINS - 1; i >= 0; i--)
            if (suspects[i] && i != margin && z[i] < -tolerances[i]) next = i;
    }
    for (int h = 0; h < N_HOLDS; h++) sharing |= step->m[hold_modes[h] + 3] > 0;
    for (int i = 0; i < N_MARGINS; i++) { /* what shares one reaction lets go together */
        bool limit = margin_kind[i] == UPPER || margin_kind[i] == LOWER;
        bool shared = sharing && limit && step->m[hold_modes[margin_number[i]] + 3] > 0;
        fired[i] = i == margin || (z[i] <= tolerances[i] && (suspects[i] || shared));
    }
    *fraction = high;
    return true;
}

/* ---- steps -------------------------------------------------------------------------------- */

static double rms(const double *values, const double *scale)
{
    double sum = 0.0;
    for (int i = 0; i < N_STATES; i++) sum += values[i] / scale[i] * (values[i] / scale[i]);
    return sqrt(sum / N_STATES);
}

static double tolerated(const Run *run, int i, double size)
{
    return fmax(run->rtol * 1e-3, 1e-12) * state_nominal[i] + run->rtol * fabs(size);
}

/* Step to begin with (Hairer, Norsett, Wanner, vol. I, II.4). */
static double first_step(const Run *run, const double *f, double end)
{
    double scale[N_STATES + 1], x[N_STATES + 1], later[N_STATES + 1], most = end - run->t;
    for (int i = 0; i < N_STATES; i++) scale[i] = tolerated(run, i, run->x[i]);
    double d0 = rms(run->x, scale), d1 = rms(f, scale);
    double h0 = fmin(d0 < 1e-5 || d1 < 1e-5 ? 1e-6 : 0.01 * d0 / d1, most);
    for (int i = 0; i < N_STATES; i++) x[i] = run->x[i] + h0 * f[i];
    rates_at(run, x, run->t + h0, run->m, later);
    for (int i = 0; i < N_STATES; i++) later[i] -= f[i];
    double steepest = fmax(d1, rms(later, scale) / h0);
    double h1 = steepest <= 1e-15 ? fmax(1e-6, h0 * 1e-3) : pow(0.01 / steepest, 1.0 / 8);
    double first = fmin(fmin(100 * h0, h1), most);
    return isfinite(first) && first > 0 ? first : 1e-6 * most;
}

/* One attempt; its error relative to the tolerance, and the derivatives at its end. */
static double attempt(Run *run, Step *step, const double *f, double *f_new)
{
    double k[ALL_STAGES][N_STATES + 1], x[N_STATES + 1], e3 = 0.0, e5 = 0.0, h = step->h;
    memcpy(step->before, run->x, sizeof step->before);
    memcpy(step->m, run->m, sizeof step->m);
    memcpy(k[0], f, sizeof k[0]);
    for (int s = 1; s < STAGES; s++) {
        combined(run->x, h, k, dop853_a[s], s, x);
        rates_at(run, x, step->t + dop853_c[s] * h, run->m, k[s]);
    }
    combined(run->x, h, k, dop853_b, STAGES, step->after);
    rates_at(run, step->after, step->t + h, run->m, k[STAGES]);
    memcpy(f_new, k[STAGES], sizeof k[0]);
    for (int i = 0; i < N_STATES; i++) {
        double third = 0.0, fifth = 0.0;
        double scale = tolerated(run, i, fmax(fabs(run->x[i]), fabs(step->after[i])));
        for (int s = 0; s <= STAGES; s++) {
            third += dop853_e3[s] * k[s][i];
            fifth += dop853_e5[s] * k[s][i];
        }
        e3 += third / scale * (third / scale);
        e5 += fifth / scale * (fifth / scale);
        if (!isfinite(step->after[i]) || !isfinite(f_new[i])) return INFINITY;
    }
    double error = h * e5 / sqrt(fmax((e5 + 0.01 * e3) * N_STATES, 1e-300));
    if (!close_guesses(run, step->after, step->t + h, step->m)) return 100.0;
    if (!N_MARGINS || !(error <= 1)) return error;
    for (int s = 0; s < 3; s++) {
        combined(run->x, h, k, dop853_ax[s], STAGES + 1 + s, x);
        rates_at(run, x, step->t + dop853_cx[s] * h, run->m, k[STAGES + 1 + s]);
    }
    for (int i = 0; i < N_STATES; i++) {
        double delta = step->after[i] - run->x[i];
        step->dense[0][i] = delta;
        step->dense[1][i] = h * f[i] - delta;
        step->dense[2][i] = 2 * delta - h * (f_new[i] + f[i]);
    }
    for (int j = 0; j < 4; j++) combined(NULL, h, k, dop853_d[j], ALL_STAGES, step->dense[3 + j]);
    return error;
}

/* Go on to an instant as far as modes stay; fired tells what must change if any does. */
static bool smooth(Run *run, double end, bool *fired, bool *crossed)
{
    double f[N_STATES + 1], f_new[N_STATES + 1], fraction;
    bool rejected = false;
    Step step;
    *crossed = false;
    rates_at(run, run->x, run->t, run->m, f);
    if (run->next_step <= 0 && N_STATES) run->next_step = first_step(run, f, end);
    for (int count = 0; run->t < end; count++) {
        bool last = !N_STATES || run->next_step >= end - run->t;
        step.t = run->t;
        step.h = last ? end - run->t : run->next_step;
        if (!N_STATES && N_MARGINS) { /* only functions of time, looked at in short pieces */
            step.h = fmin(step.h, run->span / 1000);
            last = step.h >= end - run->t;
        }
        double error = attempt(run, &step, f, f_new);
        double growth = fmin(fmax(0.9 * pow(fmax(error, 1e-12), -1.0 / 8), 0.2), rejected ? 1 : 8);
        rejected = !(error <= 1);
        if (rejected) {
            run->next_step = step.h * fmin(growth, 0.9);
            if (run->next_step < 1e-14 * fmax(fabs(run->t), 1e-6) || count > MOST_STEPS)
                return fail(run, "the step size shrank to nothing at t = %.9g s", run->t);
            continue;
        }
        if (N_MARGINS && first_crossing(run, &step, &fraction, fired)) {
            double x[N_STATES + 1];
            at(&step, fraction, x);
            memcpy(run->x, x, sizeof x);
            run->t = step.t + fraction * step.h;
            memcpy(run->m + N_MODES, step.m + N_MODES, N_GUESSES * sizeof(double));
            *crossed = true;
            return close_guesses(run, run->x, run->t, run->m);
        }
        if (!last || growth * step.h > run->next_step) run->next_step = growth * step.h;
        run->t = last ? end : step.t + step.h;
        memcpy(run->x, step.after, sizeof run->x);
        memcpy(run->m, step.m, sizeof run->m);
        memcpy(f, f_new, sizeof f);
        if (!fit_to_lead(run)) return false;
        if (count > MOST_STEPS) return fail(run, "too many steps at t = %.9g s", run->t);
    }
    return true;
}

/* Advance to a time, through all events on the way. */
bool advance(Run *run, double end)
{
    bool fired[N_MARGINS + 1] = {false}, crossed;
    double rounding = 1e-13 * fmax(run->span, fabs(end)), storm = run->t;
    int changes = 0;
    if (run->inputs_new) {
        fired_now(run, fired);
        if (!change(run, fired, rounding)) return false;
    }
    while (run->t < end) {
        double instant = next_instant(run, rounding);
        double next = instant <= end + rounding ? fmin(instant, end) : end;
        if (!smooth(run, next, fired, &crossed)) return false;
        if (!crossed && instant > end + rounding) break;
        if (!crossed) memset(fired, 0, sizeof fired);
        if (!change(run, fired, rounding)) return false;
        if (run->t - storm > 1e-9 * run->span) {
            storm = run->t;
            changes = 0;
        } else if (++changes > STORM) {
            return fail(run, "%d changes of mode at practically the same instant, t = %.9g s",
                        STORM, run->t);
        }
    }
    run->t = end;
    arm(run);
    return true;
}
