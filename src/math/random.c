/* xoshiro256++ (Blackman and Vigna 2019), seeded by splitmix64, and the distributions in use. */
#include "math/random.h"

#include <math.h>

mukca_random mukca_random_seeded(uint64_t seed)
{
    mukca_random random = {0};
    for (int i = 0; i < 4; i++) {
        uint64_t z = seed += 0x9e3779b97f4a7c15u;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        random.state[i] = z ^ (z >> 31);
    }
    return random;
}

static uint64_t rotate_left(uint64_t x, int k)
{
    return (x << k) | (x >> (64 - k));
}

uint64_t mukca_random_bits(mukca_random *random)
{
    uint64_t *s = random->state, result = rotate_left(s[0] + s[3], 23) + s[0], t = s[1] << 17;
    s[2] ^= s[0];
    s[3] ^= s[1];
    s[1] ^= s[2];
    s[0] ^= s[3];
    s[2] ^= t;
    s[3] = rotate_left(s[3], 45);
    return result;
}

double mukca_random_uniform(mukca_random *random)
{
    return (double)(mukca_random_bits(random) >> 11) * 0x1p-53;
}

double mukca_random_normal(mukca_random *random)
{
    if (random->has_spare) {
        random->has_spare = false;
        return random->spare;
    }
    double u, v, s;
    do {
        u = 2 * mukca_random_uniform(random) - 1;
        v = 2 * mukca_random_uniform(random) - 1;
        s = u * u + v * v;
    } while (s >= 1 || s == 0);
    double factor = sqrt(-2 * log(s) / s);
    random->spare = v * factor;
    random->has_spare = true;
    return u * factor;
}

int mukca_random_below(mukca_random *random, int n)
{
    uint64_t range = (uint64_t)n, bits, value;
    do bits = mukca_random_bits(random), value = bits % range;
    while (bits - value > UINT64_MAX - range); /* reject the last, incomplete range */
    return (int)value;
}
