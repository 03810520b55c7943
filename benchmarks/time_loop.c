/* Loops written by hand for `benchmarks.time_loop`: DOP853 for smooth drives, with the sums of the
   stages in stages.h, and DOPRI5 with events for three clutches. */
#include <math.h>

#define TWICE_PI 6.283185307179586
#define ERROR_POWER 0.125

typedef void (*rate_function)(double t, const double *x, double *f);

static double larger(double a, double b) { return a > b ? a : b; }
static double smaller(double a, double b) { return a < b ? a : b; }

/* -- DOP853 ----------------------------------------------------------------------------------- */

#include "stages.h"

static double norm(const double *v, const double *scale, int n)
{
    double sum = 0;
    for (int i = 0; i < n; i++) sum += (v[i] / scale[i]) * (v[i] / scale[i]);
    return sqrt(sum / n);
}

static double first_step(rate_function rate, double t, double end, const double *x, const double *f,
                         const double *scale, double *a, double *b, int n)
{
    double d0 = norm(x, scale, n), d1 = norm(f, scale, n);
    double h = smaller(d0 < 1e-5 || d1 < 1e-5 ? 1e-6 : 0.01 * d0 / d1, end - t);
    for (int i = 0; i < n; i++) a[i] = x[i] + h * f[i];
    rate(t + h, a, b);
    for (int i = 0; i < n; i++) b[i] -= f[i];
    double steepest = larger(d1, norm(b, scale, n) / h);
    double other = steepest <= 1e-15 ? larger(1e-6, h * 1e-3) : pow(0.01 / steepest, ERROR_POWER);
    return smaller(smaller(100 * h, other), end - t);
}

/* Accepted steps from t to end; x is what it becomes. `work` holds 16 n numbers. Inlined, with the
   rates and their number known. */
static inline __attribute__((always_inline)) int
dop853(rate_function rate, double t, double end, double *x, const double *atol,
                  double rtol, double *work, int n)
{
    double *k = work, *a = work + 13 * n, *new = work + 14 * n, *scale = work + 15 * n;
    int steps = 0, rejected = 0;
    rate(t, x, k);
    for (int i = 0; i < n; i++) scale[i] = atol[i] + rtol * fabs(x[i]);
    double h = first_step(rate, t, end, x, k, scale, a, new, n);
    while (t < end) {
        int last = h >= end - t;
        if (last) h = end - t;
        STAGES(rate, t, h, x, k, a, new, n)
        double e5 = 0, e3 = 0;
        for (int i = 0; i < n; i++) {
            double size = atol[i] + rtol * larger(fabs(x[i]), fabs(new[i]));
            double u = (E5(k, n, i)) / size, v = (E3(k, n, i)) / size;
            e5 += u * u;
            e3 += v * v;
        }
        double error = h * e5 / sqrt(larger((e5 + 0.01 * e3) * n, 1e-300));
        double growth = 0.9 * pow(larger(error, 1e-12), -ERROR_POWER);
        growth = smaller(larger(growth, 0.2), rejected ? 1 : 8);
        if (error <= 1) {
            t = last ? end : t + h;
            for (int i = 0; i < n; i++) x[i] = new[i];
            rate(t, x, k);
            rejected = 0;
            steps++;
        } else {
            growth = smaller(growth, 0.9);
            rejected = 1;
        }
        h *= growth;
    }
    return steps;
}

/* -- three masses, a motor torque and loads that step --------------------------------------- */

static double load;

static void three(double t, const double *x, double *f)
{
    double left = 2e4 * x[0] + 4.0 * (x[3] - x[2]), right = 1e4 * x[1] + 3.0 * (x[4] - x[3]);
    f[0] = x[3] - x[2];
    f[1] = x[4] - x[3];
    f[2] = (40 * sin(30 * t) + left) / 2.0;
    f[3] = (right - left) / 0.5;
    f[4] = (-load - right) / 1.0;
}

int run_three(double *x, double rtol, const double *atol)
{
    static const double edge[] = {0, 0.5, 1.2, 2.0}, loads[] = {0, 100, 30};
    double work[16 * 5];
    int steps = 0;
    for (int i = 0; i < 5; i++) x[i] = 0;
    for (int s = 0; s < 3; s++) {
        load = loads[s];
        steps += dop853(three, edge[s], edge[s + 1], x, atol, rtol, work, 5);
    }
    return steps;
}

/* -- a chain of 300 masses: 299 twists, then 300 speeds ----------------------------------------- */

#define MASSES 300

static void chain(double t, const double *x, double *f)
{
    const double *w = x + MASSES - 1;
    double before = -sin(20 * t);
    for (int i = 0; i < MASSES - 1; i++) {
        double twisting = w[i + 1] - w[i], after = 1e4 * x[i] + 0.5 * twisting;
        f[i] = twisting;
        f[MASSES - 1 + i] = after - before;
        before = after;
    }
    f[2 * MASSES - 2] = -before;
}

int run_chain(double *x, double rtol, const double *atol)
{
    static double work[16 * (2 * MASSES - 1)];
    for (int i = 0; i < 2 * MASSES - 1; i++) x[i] = 0;
    return dop853(chain, 0, 1, x, atol, rtol, work, 2 * MASSES - 1);
}

/* -- four bodies and three clutches -------------------------------------------------------------- */

enum { STUCK = 0, FREE = 2 }; /* and 1, -1 for the directions of sliding */

static int mode[3];

static double grip(int k, double t)
{
    if (k == 0) return t < 1.25 ? 10 * cos(0.2 * TWICE_PI * t) : 0;
    return t >= (k == 1 ? 0.4 : 0.9) ? 10 : 0;
}

/* Accelerations and torques: a[k] has tau[k], a[k + 1] has -tau[k]. */
static void torques(double t, double *a, double *tau)
{
    double drive = 10 * sin(5 * TWICE_PI * t), d[3], r[3];
    for (int k = 0; k < 3; k++) {
        /* stuck: tau[k-1] - 2 tau[k] + tau[k+1] == drive of the first body */
        d[k] = mode[k] == STUCK ? -2 : 1;
        r[k] = mode[k] == STUCK ? (k == 0 ? drive : 0) : mode[k] == FREE ? 0 : mode[k] * grip(k, t);
        if (k && mode[k] == STUCK) {
            double below = mode[k - 1] == STUCK ? 1 : 0;
            d[k] -= below / d[k - 1];
            r[k] -= r[k - 1] / d[k - 1];
        }
    }
    for (int k = 2; k >= 0; k--) {
        double above = k < 2 && mode[k] == STUCK ? tau[k + 1] : 0;
        tau[k] = (r[k] - above) / d[k];
    }
    a[0] = drive + tau[0];
    a[1] = tau[1] - tau[0];
    a[2] = tau[2] - tau[1];
    a[3] = -tau[2];
}

static void clutched(double t, const double *x, double *f)
{
    double tau[3];
    (void)x;
    torques(t, f, tau);
}

static double room(int k, double t, const double *x, const double *tau)
{
    if (mode[k] == FREE) return 1;
    if (mode[k] == STUCK) return 1.1 * grip(k, t) - fabs(tau[k]);
    return mode[k] * (x[k + 1] - x[k]);
}

/* Modes that fit: what slides at zero speed and would turn back sticks, what is overloaded slides. */
static void resolve(double t, double *x, int fired)
{
    double a[4], tau[3];
    for (int k = 0; k < 3; k++) {
        double relative = x[k + 1] - x[k];
        if (grip(k, t) <= 0) mode[k] = FREE;
        else if (mode[k] == FREE) mode[k] = relative > 0 ? 1 : relative < 0 ? -1 : STUCK;
    }
    if (fired >= 0 && mode[fired] != STUCK) {
        mode[fired] = STUCK;
        x[fired] = x[fired + 1] = 0.5 * (x[fired] + x[fired + 1]);
    } else if (fired >= 0) {
        torques(t, a, tau);
        mode[fired] = tau[fired] > 0 ? 1 : -1;
        fired = -1;
    }
    for (int round = 0; round < 20; round++) {
        int wrong = 0;
        torques(t, a, tau);
        for (int k = 0; k < 3; k++) {
            if (mode[k] == STUCK && fabs(tau[k]) > 1.1 * grip(k, t) * (1 + 1e-10)) {
                mode[k] = tau[k] > 0 ? 1 : -1;
                wrong = 1;
            } else if (mode[k] != STUCK && mode[k] != FREE && x[k + 1] == x[k] &&
                       mode[k] * (a[k + 1] - a[k]) < -1e-9) {
                mode[k] = STUCK;
                wrong = 1;
            }
        }
        if (!wrong) return;
    }
}

int run_clutches(double *x, double rtol, const double *atol)
{
    static const double edge[] = {0.4, 0.9, 1.25, 1.5};
    double t = 0, k[7][4], y[4], new[4], c[5][4], scale[4], unused[4], more[4], tau[3];
    int changes = 0;
    x[0] = 10;
    x[1] = x[2] = x[3] = 0;
    mode[0] = mode[1] = mode[2] = FREE;
    for (int s = 0; s < 4; s++) {
        double end = edge[s], h = 0;
        int fired = -1, fresh = 1, rejected = 0;
        resolve(t, x, -1);
        while (t < end) {
            if (fresh) {
                clutched(t, x, k[0]);
                for (int i = 0; i < 4; i++) scale[i] = atol[i] + rtol * fabs(x[i]);
                h = first_step(clutched, t, end, x, k[0], scale, unused, more, 4);
                fresh = 0;
            }
            int last = h >= end - t;
            if (last) h = end - t;
            /* just before the end, as the grips jump there */
            double top = last ? end - 1e-15 : t + h;
#define STAGE(at, where, to, sum) \
    for (int i = 0; i < 4; i++) y[i] = x[i] + h * (sum); \
    clutched(where, y, k[to]);
            STAGE(1, t + h / 5, 1, k[0][i] / 5)
            STAGE(2, t + 0.3 * h, 2, 3. / 40 * k[0][i] + 9. / 40 * k[1][i])
            STAGE(3, t + 0.8 * h, 3, 44. / 45 * k[0][i] - 56. / 15 * k[1][i] + 32. / 9 * k[2][i])
            STAGE(4, t + 8. / 9 * h, 4,
                  19372. / 6561 * k[0][i] - 25360. / 2187 * k[1][i] + 64448. / 6561 * k[2][i] -
                      212. / 729 * k[3][i])
            STAGE(5, top, 5,
                  9017. / 3168 * k[0][i] - 355. / 33 * k[1][i] + 46732. / 5247 * k[2][i] +
                      49. / 176 * k[3][i] - 5103. / 18656 * k[4][i])
            STAGE(6, top, 6,
                  35. / 384 * k[0][i] + 500. / 1113 * k[2][i] + 125. / 192 * k[3][i] -
                      2187. / 6784 * k[4][i] + 11. / 84 * k[5][i])
            double error = 0;
            for (int i = 0; i < 4; i++) {
                new[i] = y[i];
                double e = 71. / 57600 * k[0][i] - 71. / 16695 * k[2][i] + 71. / 1920 * k[3][i] -
                           17253. / 339200 * k[4][i] + 22. / 525 * k[5][i] - k[6][i] / 40;
                e *= h / (atol[i] + rtol * larger(fabs(x[i]), fabs(new[i])));
                error += e * e;
            }
            error = sqrt(error / 4);
            double growth = 0.9 * pow(larger(error, 1e-10), -0.2);
            growth = smaller(larger(growth, 0.2), rejected ? 1 : 8);
            if (error > 1) {
                h *= smaller(growth, 0.9);
                rejected = 1;
                continue;
            }
            rejected = 0;
            for (int i = 0; i < 4; i++) {
                c[0][i] = x[i];
                c[1][i] = new[i] - x[i];
                c[2][i] = h * k[0][i] - c[1][i];
                c[3][i] = c[1][i] - h * k[6][i] - c[2][i];
                c[4][i] = h * (-12715105075. / 11282082432 * k[0][i] +
                               87487479700. / 32700410799 * k[2][i] -
                               10690763975. / 1880347072 * k[3][i] +
                               701980252875. / 199316789632 * k[4][i] -
                               1453857185. / 822651844 * k[5][i] +
                               69997945. / 29380423 * k[6][i]);
            }
#define INSIDE(part) \
    for (int i = 0; i < 4; i++) \
        y[i] = c[0][i] + (part) * (c[1][i] + (1 - (part)) * (c[2][i] + (part) * (c[3][i] + (1 - (part)) * c[4][i]))); \
    torques(t + (part) * h, more, tau);
            double high = 2;
            for (int sample = 1; sample <= 4 && high > 1; sample++) {
                double part = sample == 4 ? (last ? 1 - 1e-14 : 1) : 0.25 * sample;
                INSIDE(part)
                for (int j = 0; j < 3; j++)
                    if (room(j, t + part * h, y, tau) < -1e-12) high = part;
            }
            fired = -1;
            while (high <= 1) {
                double low = -1, at_low = 0, root = high, value = 0;
                int which = -1;
                INSIDE(high)
                for (int j = 0; j < 3; j++)
                    if (j != fired && which < 0 && room(j, t + high * h, y, tau) < -1e-12) {
                        which = j;
                        value = room(j, t + high * h, y, tau);
                    }
                if (which < 0) break;
                low = larger(high - 0.25, 0);
                INSIDE(low)
                at_low = room(which, t + low * h, y, tau);
                for (int i = 0; i < 40 && value != 0 && fabs(root - low) > 1e-16; i++) {
                    double next = (low * value - root * at_low) / (value - at_low);
                    INSIDE(next)
                    double found = room(which, t + next * h, y, tau);
                    if (found * value < 0) {
                        low = root;
                        at_low = value;
                    } else at_low *= 0.5;
                    root = next;
                    value = found;
                }
                fired = which;
                high = root;
            }
            if (fired >= 0) {
                INSIDE(high)
                for (int i = 0; i < 4; i++) x[i] = y[i];
                t += high * h;
                resolve(t, x, fired);
                changes++;
                fresh = 1;
                continue;
            }
            for (int i = 0; i < 4; i++) {
                x[i] = new[i];
                k[0][i] = k[6][i];
            }
            t = last ? end : t + h;
            h *= growth;
        }
    }
    return changes;
}
