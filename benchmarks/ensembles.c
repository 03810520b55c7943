/* Programs written by hand for `benchmarks.ensembles`: many runs of one small system, each
   with its own parameters. They show how quick such a run can be on one thread.

   Every number is a `wide`: one double, or LANES doubles side by side in a register. Each lane has
   its own step length and accepts or rejects its own steps. When the run of a lane is over, the
   lane takes the next run that waits. GROUPS registers are advanced together, so that one computes
   while another waits for its results. */
#include <math.h>
#include <string.h>

#ifndef LANES
#define LANES 1
#endif
#ifndef GROUPS
#define GROUPS 1
#endif

#define ALWAYS static inline __attribute__((always_inline))
#define UNROLLED _Pragma("GCC unroll 16")
#define EACH_GROUP UNROLLED for (int g = 0; g < groups; g++)

/* -- numbers side by side ---------------------------------------------------------------------- */

/* A `truth` says of each lane whether something holds. */

#if LANES == 1

typedef double wide;
typedef int truth;

ALWAYS wide larger(wide a, wide b) { return a > b ? a : b; }
ALWAYS wide smaller(wide a, wide b) { return a < b ? a : b; }
ALWAYS wide size(wide a) { return fabs(a); }
ALWAYS wide root(wide a) { return sqrt(a); }
ALWAYS wide sixteenth_root(wide a) { return sqrtf(sqrtf(sqrtf(sqrtf((float)a)))); }
ALWAYS wide all(double a) { return a; }
ALWAYS truth above(wide a, wide b) { return a > b; }
ALWAYS truth both(truth a, truth b) { return a & b; }
ALWAYS wide choose(truth which, wide a, wide b) { return which ? a : b; }
ALWAYS unsigned lanes(truth which) { return (unsigned)which; }
ALWAYS truth marked(unsigned which) { return (truth)which; }

#else

#include <immintrin.h>

typedef double wide __attribute__((vector_size(8 * LANES)));

#if LANES == 4
typedef __m256d truth;

ALWAYS wide larger(wide a, wide b) { return _mm256_max_pd(a, b); }
ALWAYS wide smaller(wide a, wide b) { return _mm256_min_pd(a, b); }
ALWAYS wide size(wide a) { return _mm256_andnot_pd(_mm256_set1_pd(-0.0), a); }
ALWAYS wide root(wide a) { return _mm256_sqrt_pd(a); }
ALWAYS wide all(double a) { return _mm256_set1_pd(a); }
ALWAYS truth above(wide a, wide b) { return _mm256_cmp_pd(a, b, _CMP_GT_OQ); }
ALWAYS truth both(truth a, truth b) { return _mm256_and_pd(a, b); }
ALWAYS wide choose(truth which, wide a, wide b) { return _mm256_blendv_pd(b, a, which); }
ALWAYS unsigned lanes(truth which) { return (unsigned)_mm256_movemask_pd(which); }

ALWAYS truth marked(unsigned which)
{
    __m256i bit = _mm256_setr_epi64x(1, 2, 4, 8), set = _mm256_set1_epi64x(which);
    return _mm256_castsi256_pd(_mm256_cmpeq_epi64(_mm256_and_si256(set, bit), bit));
}

/* To three digits, which is enough for the length of a step. */
ALWAYS wide sixteenth_root(wide a)
{
    __m128 found = _mm256_cvtpd_ps(a);
    UNROLLED for (int i = 0; i < 4; i++) found = _mm_rsqrt_ps(found);
    return _mm256_cvtps_pd(found);
}
#else
typedef __mmask8 truth;

ALWAYS wide larger(wide a, wide b) { return _mm512_max_pd(a, b); }
ALWAYS wide smaller(wide a, wide b) { return _mm512_min_pd(a, b); }
ALWAYS wide size(wide a) { return _mm512_abs_pd(a); }
ALWAYS wide root(wide a) { return _mm512_sqrt_pd(a); }
ALWAYS wide all(double a) { return _mm512_set1_pd(a); }
ALWAYS truth above(wide a, wide b) { return _mm512_cmp_pd_mask(a, b, _CMP_GT_OQ); }
ALWAYS truth both(truth a, truth b) { return a & b; }
ALWAYS wide choose(truth which, wide a, wide b) { return _mm512_mask_blend_pd(which, b, a); }
ALWAYS unsigned lanes(truth which) { return which; }
ALWAYS truth marked(unsigned which) { return (truth)which; }

/* To four digits, which is enough for the length of a step. */
ALWAYS wide sixteenth_root(wide a)
{
    UNROLLED for (int i = 0; i < 4; i++) a = _mm512_rsqrt14_pd(a);
    return a;
}
#endif
#endif

/* Changes the sign of a where the last bit of `odd` is set. */
#if LANES == 1
ALWAYS wide flip(wide a, wide odd)
{
    unsigned long long x, y;
    memcpy(&x, &a, sizeof x);
    memcpy(&y, &odd, sizeof y);
    x ^= y << 63;
    memcpy(&a, &x, sizeof a);
    return a;
}
#else
typedef long long whole __attribute__((vector_size(8 * LANES)));

ALWAYS wide flip(wide a, wide odd) { return (wide)((whole)a ^ ((whole)odd << 63)); }
#endif

/* One double of a wide. */
#define LANE(value, l) (((double *)&(value))[l])

/* -- DOP853 ------------------------------------------------------------------------------------ */

#define MOST 8    /* room for states, and for what a rate hands out beside them */
#define STAGES 16 /* the last three only for values inside a step */

/* One register full of runs. */
typedef struct {
    wide p[12];      /* parameters */
    wide x[MOST];    /* states */
    wide next[MOST]; /* states after the step that is tried */
    wide h;          /* its length */
    wide left;       /* time until the end of the run */
    wide most;       /* limit of growth of the next step */
    wide tried;      /* steps so far */
    wide done;       /* and those accepted */
    wide kept;       /* what a task gathers on the way */
    long row[LANES]; /* which run is in a lane; -1: none that counts */
    unsigned over;   /* lanes whose run is over */
} group;

typedef wide rates[STAGES][MOST];
typedef void (*rate_function)(const wide *p, const wide *x, wide *f);

/* A part of a sum over stages, for state i of group g. */
#define K(j, factor) (factor) * k[g][j][i]

/* Stage j: the newest rate, k[l], comes in last, so that nothing else waits for it. */
#define STAGE(j, older, l, factor) \
    { \
        wide newest[GROUPS]; \
        EACH_GROUP newest[g] = s[g].h * (factor); \
        UNROLLED for (int i = 0; i < n; i++) \
            EACH_GROUP y[g][i] = newest[g] * k[g][l][i] + (s[g].x[i] + s[g].h * (older)); \
        EACH_GROUP rate(s[g].p, y[g], k[g][j]); \
    }

/* Tries a step of each group; k[g][0] is the rate at its beginning. `fit` becomes 1 / error^2, with
   the error in units of what the tolerance allows. */
ALWAYS void attempt(rate_function rate, int n, int groups, group *s, rates *k, const double *atol,
                    double rtol, wide *fit)
{
    wide y[GROUPS][MOST], fifth[GROUPS], third[GROUPS];
    UNROLLED for (int i = 0; i < n; i++)
        EACH_GROUP y[g][i] = s[g].x[i] + s[g].h * (K(0, 0.05260015195876773));
    EACH_GROUP rate(s[g].p, y[g], k[g][1]);
    STAGE(2, K(0, 0.0197250569845379), 1, 0.0591751709536137)
    STAGE(3, K(0, 0.02958758547680685), 2, 0.08876275643042054)
    STAGE(4, K(0, 0.2413651341592667) + K(2, -0.8845494793282861), 3, 0.924834003261792)
    STAGE(5, K(0, 0.037037037037037035) + K(3, 0.17082860872947386), 4, 0.12546768756682242)
    STAGE(6, K(0, 0.037109375) + K(3, 0.17025221101954405) + K(4, 0.06021653898045596),
             5, -0.017578125)
    STAGE(7, K(0, 0.03709200011850479) + K(3, 0.17038392571223998) + K(4, 0.10726203044637328) +
             K(5, -0.015319437748624402), 6, 0.008273789163814023)
    STAGE(8, K(0, 0.6241109587160757) + K(3, -3.3608926294469414) + K(4, -0.868219346841726) +
             K(5, 27.59209969944671) + K(6, 20.154067550477894), 7, -43.48988418106996)
    STAGE(9, K(0, 0.47766253643826434) + K(3, -2.4881146199716677) + K(4, -0.590290826836843) +
             K(5, 21.230051448181193) + K(6, 15.279233632882423) + K(7, -33.28821096898486),
             8, -0.020331201708508627)
    STAGE(10, K(0, -0.9371424300859873) + K(3, 5.186372428844064) + K(4, 1.0914373489967295) +
              K(5, -8.149787010746927) + K(6, -18.52006565999696) + K(7, 22.739487099350505) +
              K(8, 2.4936055526796523), 9, -3.0467644718982196)
    STAGE(11, K(0, 2.273310147516538) + K(3, -10.53449546673725) + K(4, -2.0008720582248625) +
              K(5, -17.9589318631188) + K(6, 27.94888452941996) + K(7, -2.8589982771350235) +
              K(8, -8.87285693353063) + K(9, 12.360567175794303), 10, 0.6433927460157636)
    EACH_GROUP fifth[g] = third[g] = all(0);
    UNROLLED for (int i = 0; i < n; i++) EACH_GROUP {
        wide sum = K(0, 0.054293734116568765) + K(5, 4.450312892752409) +
                   K(6, 1.8915178993145003) + K(7, -5.801203960010585) +
                   K(8, 0.3111643669578199) + K(9, -0.1521609496625161) +
                   K(10, 0.20136540080403034) + K(11, 0.04471061572777259);
        s[g].next[i] = s[g].x[i] + s[g].h * sum;
        wide weight = 1 / (atol[i] + rtol * larger(size(s[g].x[i]), size(s[g].next[i])));
        wide e5 = K(0, 0.01312004499419488) + K(5, -1.2251564463762044) +
                  K(6, -0.4957589496572502) + K(7, 1.6643771824549864) +
                  K(8, -0.35032884874997366) + K(9, 0.3341791187130175) +
                  K(10, 0.08192320648511571) + K(11, -0.022355307863886294);
        wide e3 = sum - K(0, 0.2440944881889764) - K(8, 0.7338466882816118) -
                  K(11, 0.022058823529411766);
        e5 *= weight;
        e3 *= weight;
        fifth[g] += e5 * e5;
        third[g] += e3 * e3;
    }
    /* The small numbers keep a step without error from dividing zero by zero. */
    EACH_GROUP {
        wide product = s[g].h * fifth[g];
        fit[g] = (n * (fifth[g] + 0.01 * third[g]) + 1e-60) / (product * product + 1e-120);
    }
}

/* Factor of the next step: 0.9 error^(-1/8) within limits. */
ALWAYS wide growth(wide fit, wide most)
{
    return smaller(larger(0.9 * sixteenth_root(fit), all(0.2)), most);
}

/* Hairer's first step. k[0] is the rate at x; changes k[1]. */
ALWAYS wide first_step(rate_function rate, int n, const group *s, wide (*k)[MOST],
                       const double *atol, double rtol)
{
    wide y[MOST], weight[MOST], d0 = all(0), d1 = all(0), d2 = all(0);
    UNROLLED for (int i = 0; i < n; i++) {
        weight[i] = 1 / (atol[i] + rtol * size(s->x[i]));
        wide value = weight[i] * s->x[i], slope = weight[i] * k[0][i];
        d0 += value * value;
        d1 += slope * slope;
    }
    d0 = root(d0 / n);
    d1 = root(d1 / n);
    wide guess = choose(above(smaller(d0, d1), all(1e-5)), 0.01 * d0 / d1, all(1e-6));
    UNROLLED for (int i = 0; i < n; i++) y[i] = s->x[i] + guess * k[0][i];
    rate(s->p, y, k[1]);
    UNROLLED for (int i = 0; i < n; i++) {
        wide change = weight[i] * (k[1][i] - k[0][i]);
        d2 += change * change;
    }
    wide steepest = larger(larger(d1, root(d2 / n) / guess), all(1e-15));
    return smaller(100 * guess, root(root(root(0.01 / steepest))));
}

/* The last three stages of one group; k[0][12] is the rate at the end of the step. */
ALWAYS void more_stages(rate_function rate, int n, const group *s, rates *k)
{
    enum { groups = 1 };
    wide y[1][MOST];
    STAGE(13, K(0, 0.056167502283047954) + K(6, 0.25350021021662483) + K(7, -0.2462390374708025) +
              K(8, -0.12419142326381637) + K(9, 0.15329179827876568) + K(10, 0.00820105229563469) +
              K(11, 0.007567897660545699), 12, -0.008298)
    STAGE(14, K(0, 0.03183464816350214) + K(5, 0.028300909672366776) + K(6, 0.053541988307438566) +
              K(7, -0.05492374857139099) + K(10, -0.00010834732869724932) +
              K(11, 0.0003825710908356584) + K(12, -0.00034046500868740456), 13, 0.1413124436746325)
    STAGE(15, K(0, -0.42889630158379194) + K(5, -4.697621415361164) + K(6, 7.683421196062599) +
              K(7, 4.06898981839711) + K(8, 0.3567271874552811) + K(12, -0.0013990241651590145) +
              K(13, 2.9475147891527724), 14, -9.15095847217987)
}

/* The polynomial of one quantity over the step: `before` and `after` are its values at both ends,
   r[j] its rate at stage j. */
ALWAYS void polynomial(wide h, wide before, wide after, const wide *r, wide *c)
{
    c[0] = before;
    c[1] = after - before;
    c[2] = h * r[0] - c[1];
    c[3] = 2 * c[1] - h * (r[12] + r[0]);
    c[4] = h * (-8.428938276109013 * r[0] + 0.5667149535193777 * r[5] - 3.0689499459498917 * r[6] +
                2.38466765651207 * r[7] + 2.117034582445028 * r[8] - 0.871391583777973 * r[9] +
                2.2404374302607883 * r[10] + 0.6315787787694688 * r[11] -
                0.08899033645133331 * r[12] + 18.148505520854727 * r[13] -
                9.194632392478356 * r[14] - 4.436036387594894 * r[15]);
    c[5] = h * (10.427508642579134 * r[0] + 242.28349177525817 * r[5] + 165.20045171727028 * r[6] -
                374.5467547226902 * r[7] - 22.113666853125306 * r[8] + 7.733432668472264 * r[9] -
                30.674084731089398 * r[10] - 9.332130526430229 * r[11] +
                15.697238121770845 * r[12] - 31.139403219565178 * r[13] -
                9.35292435884448 * r[14] + 35.81684148639408 * r[15]);
    c[6] = h * (19.985053242002433 * r[0] - 387.0373087493518 * r[5] - 189.17813819516758 * r[6] +
                527.8081592054236 * r[7] - 11.57390253995963 * r[8] + 6.8812326946963 * r[9] -
                1.0006050966910838 * r[10] + 0.7777137798053443 * r[11] -
                2.778205752353508 * r[12] - 60.19669523126412 * r[13] +
                84.32040550667716 * r[14] + 11.99229113618279 * r[15]);
    c[7] = h * (-25.69393346270375 * r[0] - 154.18974869023643 * r[5] - 231.5293791760455 * r[6] +
                357.6391179106141 * r[7] + 93.40532418362432 * r[8] - 37.45832313645163 * r[9] +
                104.0996495089623 * r[10] + 29.8402934266605 * r[11] - 43.53345659001114 * r[12] +
                96.32455395918828 * r[13] - 39.17726167561544 * r[14] - 149.72683625798564 * r[15]);
}

/* Its value at the part s of the step, from 0 to 1. */
ALWAYS wide inside(const wide *c, wide s)
{
    wide back = 1 - s, value = c[7];
    UNROLLED for (int j = 6; j >= 0; j--) value = c[j] + (j % 2 ? back : s) * value;
    return value;
}

/* -- many runs --------------------------------------------------------------------------------- */

typedef struct {
    rate_function rate;
    /* Sets up a lane: derived parameters and start values from a row of parameters. */
    void (*begin)(group *s, int lane, const double *row);
    /* Looks at a step that at least one lane accepts; k[0][12] is the rate at its end. */
    void (*watch)(group *s, rates *k, truth accepted);
    /* Writes what was asked for at the end of a run. */
    void (*finish)(group *s, int lane, double *found);
    int states;     /* they count in the error */
    int rates;      /* states, and what the rate hands out beside them */
    int parameters; /* in a row */
    int quantities; /* that are asked for */
    double end;
    double first; /* first step; zero: by Hairer's rule */
} task;

/* All runs of a task. `steps` becomes the number of accepted steps and of rejected ones. */
ALWAYS void all_runs(task a, const double *parameters, long count, const double *atol, double rtol,
                     double *found, long *steps)
{
    enum { groups = GROUPS };
    group s[GROUPS];
    rates k[GROUPS];
    wide fit[GROUPS];
    long next = 0, open = 0;
    memset(s, 0, sizeof s);
    memset(k, 0, sizeof k);
    steps[0] = steps[1] = 0;
    if (count <= 0) return;
    for (int g = 0; g < GROUPS; g++) {
        s[g].over = (1u << LANES) - 1;
        for (int l = 0; l < LANES; l++) s[g].row[l] = -1;
    }
    for (;;) {
        EACH_GROUP if (s[g].over) {
            for (int l = 0; l < LANES; l++) {
                if (!(s[g].over >> l & 1)) continue;
                long row = s[g].row[l];
                if (row >= 0) {
                    a.finish(&s[g], l, found + row * a.quantities);
                    steps[0] += (long)LANE(s[g].done, l);
                    steps[1] += (long)(LANE(s[g].tried, l) - LANE(s[g].done, l));
                    open--;
                }
                /* When no run waits, the lane repeats the last one and nobody looks. */
                row = next < count ? next : count - 1;
                a.begin(&s[g], l, parameters + row * a.parameters);
                s[g].row[l] = next < count ? row : -1;
                open += next < count;
                next += next < count;
            }
            truth fresh = marked(s[g].over);
            s[g].kept = choose(fresh, all(0), s[g].kept);
            s[g].tried = choose(fresh, all(0), s[g].tried);
            s[g].done = choose(fresh, all(0), s[g].done);
            s[g].left = choose(fresh, all(a.end), s[g].left);
            s[g].most = choose(fresh, all(8), s[g].most);
            a.rate(s[g].p, s[g].x, k[g][0]); /* in the other lanes as before */
            wide first = a.first > 0 ? all(a.first)
                                     : first_step(a.rate, a.states, &s[g], k[g], atol, rtol);
            s[g].h = choose(fresh, first, s[g].h);
        }
        if (!open) return;
        EACH_GROUP s[g].h = smaller(s[g].h, s[g].left);
        attempt(a.rate, a.states, GROUPS, s, k, atol, rtol, fit);
        EACH_GROUP {
            truth accepted = above(fit[g], all(1));
            wide factor = growth(fit[g], s[g].most);
            s[g].tried += 1;
            s[g].most = choose(accepted, all(8), all(1));
            s[g].over = 0;
            if (lanes(accepted)) {
                a.rate(s[g].p, s[g].next, k[g][12]);
                a.watch(&s[g], &k[g], accepted);
                UNROLLED for (int i = 0; i < a.states; i++)
                    s[g].x[i] = choose(accepted, s[g].next[i], s[g].x[i]);
                UNROLLED for (int i = 0; i < a.rates; i++)
                    k[g][0][i] = choose(accepted, k[g][12][i], k[g][0][i]);
                s[g].left = choose(accepted, s[g].left - s[g].h, s[g].left);
                s[g].done = choose(accepted, s[g].done + 1, s[g].done);
                s[g].over = ~lanes(above(s[g].left, all(0))) & ((1u << LANES) - 1);
            }
            s[g].h *= factor;
        }
    }
}

/* -- a: three masses on two shafts, the greatest torque ---------------------------------------- */

/* States: twists, then speeds. Beside their rates: torques of the shafts.
   p: 1/J of the masses, stiffnesses, dampings. */
#define DRIVE 100.0
#define BETA 1e-4

ALWAYS void rate_a(const wide *p, const wide *x, wide *f)
{
    wide v1 = x[3] - x[2], v2 = x[4] - x[3];
    wide torque1 = p[5] * v1 + p[3] * x[0], torque2 = p[6] * v2 + p[4] * x[1];
    f[0] = v1;
    f[1] = v2;
    f[2] = p[0] * torque1 + p[7];
    f[3] = p[1] * (torque2 - torque1);
    f[4] = -p[2] * torque2;
    f[5] = torque1;
    f[6] = torque2;
}

ALWAYS void begin_a(group *s, int lane, const double *row)
{
    for (int i = 0; i < 3; i++) LANE(s->p[i], lane) = 1 / row[i];
    for (int i = 3; i < 5; i++) {
        LANE(s->p[i], lane) = row[i];
        LANE(s->p[i + 2], lane) = row[i] * BETA;
    }
    LANE(s->p[7], lane) = DRIVE / row[0];
    for (int i = 0; i < 5; i++) LANE(s->x[i], lane) = 0;
}

/* The greatest size of a polynomial inside the step: the best of some samples, then Newton's
   method. */
#define SAMPLES 8

ALWAYS wide peak(const wide *c)
{
    wide best = all(0), at = all(0);
    UNROLLED for (int j = 1; j < SAMPLES; j++) {
        wide s = all((double)j / SAMPLES), value = size(inside(c, s));
        truth better = above(value, best);
        best = choose(better, value, best);
        at = choose(better, s, at);
    }
    wide low = at - 1.0 / SAMPLES, high = at + 1.0 / SAMPLES;
    UNROLLED for (int round = 0; round < 2; round++) {
        wide value = c[7], slope = all(0), bend = all(0); /* half the second derivative */
        UNROLLED for (int j = 6; j >= 0; j--) {
            wide factor = j % 2 ? 1 - at : at;
            bend = factor * bend + (j % 2 ? -slope : slope);
            slope = factor * slope + (j % 2 ? -value : value);
            value = factor * value + c[j];
        }
        wide next = smaller(larger(at - slope / (2 * bend), low), high);
        at = choose(above(all(0), bend * value), next, at);
    }
    return larger(best, size(inside(c, at)));
}

/* Stages give torques inside the step. They are a little off and miss the peak by a little: by
   1.1 % at most at a tolerance of 1e-5, by less at tighter ones. So the peak is looked for only
   where they come within 5 % of the record. At 1e-4 the steps are too long for this. */
#define NEAR 1.05

/* Looks for the peak of the shafts whose bit is set in `which`. This is rare, so it works on copies
   and is not inlined: the loop over the steps keeps its registers. */
static __attribute__((noinline)) void look_inside(group *s, rates *k, unsigned which, wide *peaks)
{
    more_stages(rate_a, 5, s, k);
    for (int i = 0; i < 2; i++) {
        if (!(which >> i & 1)) continue;
        wide r[STAGES], c[8];
        UNROLLED for (int j = 0; j < STAGES; j++)
            r[j] = s->p[3 + i] * (*k)[j][i] + s->p[5 + i] * ((*k)[j][3 + i] - (*k)[j][2 + i]);
        polynomial(s->h, (*k)[0][5 + i], (*k)[12][5 + i], r, c);
        peaks[i] = peak(c);
    }
}

ALWAYS void watch_a(group *s, rates *k, truth accepted)
{
    wide before = s->kept, sample[2];
    wide ends = larger(size((*k)[12][5]), size((*k)[12][6]));
    wide record = s->kept = choose(accepted, larger(before, ends), before);
    UNROLLED for (int i = 0; i < 2; i++) {
        sample[i] = larger(size((*k)[7][5 + i]), size((*k)[9][5 + i]));
        sample[i] = larger(sample[i], size((*k)[10][5 + i]));
        sample[i] = larger(sample[i], size((*k)[12][5 + i]));
        sample[i] = larger(sample[i], size((*k)[0][5 + i]));
    }
    truth near = both(accepted, above(NEAR * larger(sample[0], sample[1]), record));
    if (__builtin_expect(lanes(near), 0)) {
        unsigned which = 0;
        UNROLLED for (int i = 0; i < 2; i++)
            if (lanes(both(accepted, above(NEAR * sample[i], record)))) which |= 1 << i;
        group s_copy;
        rates k_copy;
        wide peaks[2] = {all(0), all(0)};
        s_copy.h = s->h;
        UNROLLED for (int i = 0; i < 8; i++) s_copy.p[i] = s->p[i];
        UNROLLED for (int i = 0; i < 5; i++) s_copy.x[i] = s->x[i];
        UNROLLED for (int i = 0; i < 7; i++) {
            k_copy[0][i] = (*k)[0][i];
            k_copy[12][i] = (*k)[12][i];
        }
        UNROLLED for (int j = 5; j < 12; j++)
            UNROLLED for (int i = 0; i < 5; i++) k_copy[j][i] = (*k)[j][i];
        look_inside(&s_copy, &k_copy, which, peaks);
        s->kept = choose(near, larger(record, larger(peaks[0], peaks[1])), record);
    }
}

ALWAYS void finish_a(group *s, int lane, double *found) { found[0] = LANE(s->kept, lane); }

void task_a(const double *parameters, long count, double rtol, double *found, long *steps)
{
    /* Twists are some 1e-3 rad, so the error that is allowed near zero is smaller for them. */
    double small = rtol * 1e-3, atol[5] = {small * 1e-4, small * 1e-4, small, small, small};
    task a = {rate_a, begin_a, watch_a, finish_a, 5, 7, 5, 1, 2.0, 0};
    all_runs(a, parameters, count, atol, rtol, found, steps);
}

/* -- b: three clutches in a row, locked one after the other ------------------------------------ */

/* Every clutch starts with the body before it the faster one, slips with its full torque until the
   speeds meet, and stays locked. */
static const double inertia[4] = {1.0, 1.5, 0.8, 2.0}, start_speed[4] = {30, 18, 12, 4};
#define MOTOR 2.0

#if LANES == 1 && GROUPS == 1

/* States: speeds, then heat. p: torques of the clutches that slip, 1 for those that are locked,
   1/J of what moves together, at the last body of it. */
ALWAYS void rate_b(const double *p, const double *x, double *f)
{
    double sum[4];
    sum[0] = MOTOR - p[0];
    for (int i = 1; i < 4; i++) sum[i] = p[i - 1] - (i < 3 ? p[i] : 0) + p[2 + i] * sum[i - 1];
    f[3] = sum[3] * p[9];
    for (int i = 2; i >= 0; i--) f[i] = p[3 + i] != 0 ? f[i + 1] : sum[i] * p[6 + i];
    f[4] = p[0] * (x[0] - x[1]) + p[1] * (x[1] - x[2]) + p[2] * (x[2] - x[3]);
}

/* Where a polynomial that starts above zero and ends below it crosses zero. */
static double crossing(const double *c)
{
    double low = 0, at_low = inside(c, 0), high = 1, at_high = inside(c, 1);
    for (int round = 0; round < 50; round++) {
        double s = (low * at_high - high * at_low) / (at_high - at_low), value = inside(c, s);
        if (value == 0 || s <= low || s >= high || high - low < 1e-15) return s;
        if (value > 0) {
            low = s;
            at_low = value;
            at_high *= 0.5;
        } else {
            high = s;
            at_high = value;
            at_low *= 0.5;
        }
    }
    return high;
}

/* DOP853, with the locks found on the polynomial of the step. */
void task_b(const double *parameters, long count, double rtol, double *found, long *steps)
{
    enum { n = 5 };
    double atol[n];
    for (int i = 0; i < n; i++) atol[i] = rtol * 1e-3;
    steps[0] = steps[1] = 0;
    for (long run = 0; run < count; run++) {
        const double *torque = parameters + 3 * run;
        double t = 0, *row = found + 4 * run;
        group s;
        rates k[1];
        int locked[3] = {0, 0, 0};
        for (int i = 0; i < 4; i++) s.x[i] = start_speed[i];
        s.x[4] = 0;
        for (int locks = 0; locks < 3; locks++) {
            double mass = 0;
            for (int i = 0; i < 4; i++) {
                mass += inertia[i];
                s.p[6 + i] = 1 / mass;
                if (i < 3) {
                    s.p[i] = locked[i] ? 0 : torque[i];
                    s.p[3 + i] = locked[i];
                    if (!locked[i]) mass = 0;
                }
            }
            rate_b(s.p, s.x, k[0][0]);
            s.h = first_step(rate_b, n, &s, k[0], atol, rtol);
            s.most = 8;
            for (;;) {
                double fit;
                attempt(rate_b, n, 1, &s, k, atol, rtol, &fit);
                double factor = growth(fit, s.most);
                s.most = fit > 1 ? 8 : 1;
                if (fit <= 1) {
                    steps[1]++;
                    s.h *= factor;
                    continue;
                }
                steps[0]++;
                rate_b(s.p, s.next, k[0][12]);
                /* A clutch never turns away again before it locks, so the ends of a step tell. */
                int which = -1;
                double at = 2, c[8], r[STAGES];
                for (int i = 0; i < 3; i++) {
                    if (locked[i] || s.next[i] > s.next[i + 1]) continue;
                    if (which < 0) more_stages(rate_b, n, &s, k);
                    for (int j = 0; j < STAGES; j++) r[j] = k[0][j][i] - k[0][j][i + 1];
                    polynomial(s.h, s.x[i] - s.x[i + 1], s.next[i] - s.next[i + 1], r, c);
                    double here = crossing(c);
                    if (here < at) {
                        at = here;
                        which = i;
                    }
                }
                if (which >= 0) {
                    for (int i = 0; i < n; i++) {
                        for (int j = 0; j < STAGES; j++) r[j] = k[0][j][i];
                        polynomial(s.h, s.x[i], s.next[i], r, c);
                        s.x[i] = inside(c, at);
                    }
                    t += at * s.h;
                    row[which] = t;
                    locked[which] = 1;
                    break;
                }
                t += s.h;
                for (int i = 0; i < n; i++) {
                    s.x[i] = s.next[i];
                    k[0][0][i] = k[0][12][i];
                }
                s.h *= factor;
            }
        }
        row[3] = s.x[4];
    }
}

#endif

/* -- c: a motor on a shaft drives a crank with a rod ------------------------------------------- */

/* Sine and cosine: whole half turns are taken off, polynomials do the rest, to 1e-15. */
ALWAYS void turn(wide angle, wide *sine, wide *cosine)
{
    const double rounding = 6755399441055744.0; /* 1.5 * 2^52: a sum with it is a whole number */
    wide odd = angle * 0.3183098861837907 + rounding;
    wide r = angle - (odd - rounding) * 3.141592653589793;
    wide z = r * r, z2 = z * z, z4 = z2 * z2;
    wide s0 = 0.008333333333325924 * z - 0.1666666666666665;
    wide s1 = 2.7557318054759828e-06 * z - 0.00019841269836464261;
    wide s2 = 1.6050969060976222e-10 * z - 2.505197284118095e-08;
    wide s = z4 * (s2 - 7.408007994475488e-13 * z2) + (s1 * z2 + s0);
    wide c0 = 0.04166666666666666 - 0.0013888888888884763 * z;
    wide c1 = 2.4801587298910837e-05 - 2.7557318572843985e-07 * z;
    wide c2 = 2.087668151380221e-09 - 1.1466250480347138e-11 * z;
    wide c = z4 * (4.646409789893425e-14 * z2 + c2) + (c1 * z2 + c0);
    *sine = flip(r * z * s + r, odd);
    *cosine = flip(z2 * c + (1 - 0.5 * z), odd);
}

/* States: angle of the crank, its speed, speed of the motor, twist. Beside their rates: square of
   the torque of the shaft. p: c, J2, (l/r)^2, m r^2, 150 r, 1/J1, 60/J1, 0.75/J1.
   With u = sin, v = cos, q = (l/r)^2 - u^2 and R = sqrt(q): s' = -r u (R + v) / R and
   s'' = -r (q (v R + v^2 - u^2) + u^2 v^2) / (q R). The equation of motion times q^2 needs only
   one root and one quotient. */
ALWAYS void rate_c(const wide *p, const wide *x, wide *f)
{
    wide u, v, w = x[1];
    turn(x[0], &u, &v);
    wide slip = x[2] - w, tau = 1.5 * slip + p[0] * x[3];
    wide u2 = u * u, v2 = 1 - u2, q = p[2] - u2, R = root(q);
    wide first = u * (R + v);                         /* -s' R / r */
    wide second = q * (v * R + (v2 - u2)) + u2 * v2; /* -s'' q R / r */
    wide inertia_of_slider = p[3] * first;
    wide top = q * ((tau - 0.2 * w) * q - p[4] * first * R) -
               inertia_of_slider * (w * w) * second;
    f[0] = w;
    f[1] = top / (q * (p[1] * q + inertia_of_slider * first));
    f[2] = (p[6] - p[7] * x[2]) - p[5] * tau;
    f[3] = slip;
    f[4] = tau * tau;
}

ALWAYS void begin_c(group *s, int lane, const double *row)
{
    double J1 = row[0], r = row[3], ratio = row[4] / r;
    double p[8] = {row[1],  row[2], ratio * ratio, row[5] * r * r,
                   150 * r, 1 / J1, 60 / J1,       0.75 / J1};
    for (int i = 0; i < 8; i++) LANE(s->p[i], lane) = p[i];
    LANE(s->x[0], lane) = 0.3;
    for (int i = 1; i < 4; i++) LANE(s->x[i], lane) = 0;
}

/* Adds up the integral of the square of the torque. */
ALWAYS void watch_c(group *s, rates *k, truth accepted)
{
    enum { g = 0, i = 4 };
    wide sum = K(0, 0.054293734116568765) + K(5, 4.450312892752409) + K(6, 1.8915178993145003) +
               K(7, -5.801203960010585) + K(8, 0.3111643669578199) + K(9, -0.1521609496625161) +
               K(10, 0.20136540080403034) + K(11, 0.04471061572777259);
    s->kept = choose(accepted, s->kept + s->h * sum, s->kept);
}

ALWAYS void finish_c(group *s, int lane, double *found)
{
    found[0] = LANE(s->x[0], lane);
    found[1] = LANE(s->x[1], lane);
    found[2] = sqrt(LANE(s->kept, lane) / 1.5);
}

void task_c(const double *parameters, long count, double rtol, double *found, long *steps)
{
    double small = rtol * 1e-3, atol[4] = {small, small, small, small};
    task c = {rate_c, begin_c, watch_c, finish_c, 4, 5, 6, 3, 1.5, 0};
    all_runs(c, parameters, count, atol, rtol, found, steps);
}

/* -- d: Lorenz, the state at the end ----------------------------------------------------------- */

ALWAYS void rate_d(const wide *p, const wide *x, wide *f)
{
    f[0] = 10 * (x[1] - x[0]);
    f[1] = x[0] * (p[0] - x[2]) - x[1];
    f[2] = x[0] * x[1] - 2.666 * x[2];
}

ALWAYS void begin_d(group *s, int lane, const double *row)
{
    LANE(s->p[0], lane) = row[0];
    LANE(s->x[0], lane) = 1;
    LANE(s->x[1], lane) = LANE(s->x[2], lane) = 0;
}

ALWAYS void watch_d(group *s, rates *k, truth accepted)
{
    (void)s, (void)k, (void)accepted;
}

ALWAYS void finish_d(group *s, int lane, double *found)
{
    for (int i = 0; i < 3; i++) found[i] = LANE(s->x[i], lane);
}

void task_d(const double *parameters, long count, double rtol, double *found, long *steps)
{
    double atol[3] = {rtol, rtol, rtol};
    task d = {rate_d, begin_d, watch_d, finish_d, 3, 3, 1, 3, 1.0, 1e-3};
    all_runs(d, parameters, count, atol, rtol, found, steps);
}
