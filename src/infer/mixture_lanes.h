/* Factorisation for several prior sizes at a time; included by mixture.c for each number of lanes.
 */

/* Entry i of x, from the preceding ones. */
MUKCA_INLINE void LANES_OF(solve_row)(double (*x)[MUKCA_MOST_SIZES],
                                      const double (*row)[MUKCA_MOST_SIZES], int i)
{
    VECTOR sum = LOAD(x[i]);
    for (int c = 0; c < i; c++) sum -= LOAD(row[c]) * LOAD(x[c]);
    STORE(x[i], sum / LOAD(row[i]));
}

/* Entries [from, i] of row i of L.  A pivot that is not positive results in NaN. */
MUKCA_INLINE void LANES_OF(factor_row)(double (*L)[MUKCA_MOST_SIZES], int i, int from,
                                       const double *G, VECTOR s)
{
    double(*row)[MUKCA_MOST_SIZES] = ROW(L, i);
    for (int j = from; j <= i; j++) {
        double(*other)[MUKCA_MOST_SIZES] = ROW(L, j);
        VECTOR sum = s * G[j];
        if (i == j) sum += 1;
        for (int c = 0; c < j; c++) sum -= LOAD(row[c]) * LOAD(other[c]);
        if (i != j) sum /= LOAD(other[j]);
        STORE(row[j], sum);
    }
    for (int l = 0; l < LANES; l++) row[i][l] = sqrt(row[i][l]);
}

/* The lanes from `lane` on, for the squared sizes from there on.  Four rows at a time: the
 * subtractions from one sum are sequential. */
MUKCA_INLINE void LANES_OF(factor)(mukca_mixture_scratch *f, int k, const double *G,
                                   const double s2[MUKCA_MOST_SIZES], int lane)
{
    double(*L)[MUKCA_MOST_SIZES] = (double(*)[MUKCA_MOST_SIZES])(f->L[0] + lane),
    (*x)[MUKCA_MOST_SIZES] = (double(*)[MUKCA_MOST_SIZES])(f->x[0] + lane);
    const VECTOR s = LOAD(s2 + lane);
    for (int first = 0; first < k; first += 4) {
        double(*row[4])[MUKCA_MOST_SIZES];
        const double *g[4];
        for (int r = 0; r < 4; r++) { /* beyond the last row: the last row again */
            const int i = first + r < k ? first + r : k - 1;
            row[r] = ROW(L, i), g[r] = G + i * k;
        }
        for (int j = 0; j < first; j++) {
            double(*other)[MUKCA_MOST_SIZES] = ROW(L, j);
            VECTOR a[4];
            for (int r = 0; r < 4; r++) a[r] = s * g[r][j];
            for (int c = 0; c < j; c++)
                for (int r = 0; r < 4; r++) a[r] -= LOAD(row[r][c]) * LOAD(other[c]);
            for (int r = 0; r < 4; r++) STORE(row[r][j], a[r] / LOAD(other[j]));
        }
        for (int i = first; i < first + 4 && i < k; i++) {
            LANES_OF(factor_row)(L, i, first, G + i * k, s);
            LANES_OF(solve_row)(x, (const double(*)[MUKCA_MOST_SIZES])ROW(L, i), i);
        }
    }
}
