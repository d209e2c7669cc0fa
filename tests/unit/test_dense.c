/* Dense algebra: against definitions in long double, known spectra, and awkward matrices. */
#include "close.h"
#include "math/dense.h"
#include "math/random.h"

enum { MAX = 70 };

static double hilbert(int i, int j)
{
    return 1.0 / (i + j + 1);
}

static void fill(double *A, int count, uint64_t seed)
{
    mukca_random random = mukca_random_seeded(seed);
    for (int i = 0; i < count; i++) A[i] = mukca_random_normal(&random);
}

TEST(test_gram)
{
    static const int shape[][2] = {{1, 1}, {5, 3}, {7, 8}, {64, 9}, {65, 12}, {200, 50}, {131, 63}};
    static double X[200 * 67], Y[200 * 13], C[63 * 63], D[63 * 17];
    fill(X, 200 * 67, 1);
    fill(Y, 200 * 13, 2);
    for (size_t s = 0; s < sizeof shape / sizeof *shape; s++) {
        int m = shape[s][0], n = shape[s][1], ldx = n + 4, k = 1 + (int)s * 2;
        for (int i = 0; i < n * n; i++) C[i] = 1;
        for (int i = 0; i < n * k; i++) D[i] = 2;
        mukca_dense_syrk(C, n, X, m, ldx);
        mukca_dense_xty(D, (mukca_columns){X, n, ldx}, (mukca_columns){Y, k, 13}, m);
        for (int i = 0; i < n; i++) {
            for (int j = 0; j < n; j++) {
                long double sum = 1;
                for (int r = 0; r < m; r++) sum += (long double)X[r * ldx + i] * X[r * ldx + j];
                assert_close(C[i * n + j], (double)sum, 1e-12);
            }
            for (int j = 0; j < k; j++) {
                long double sum = 2;
                for (int r = 0; r < m; r++) sum += (long double)X[r * ldx + i] * Y[r * 13 + j];
                assert_close(D[i * k + j], (double)sum, 1e-12);
            }
        }
    }
}

TEST(test_cholesky)
{
    enum { N = 50, K = 11 };
    static double X[80 * N], A[N * N], L[N * N], b[N * K], x[N * K];
    fill(X, 80 * N, 3);
    fill(b, N * K, 4);
    memset(A, 0, sizeof A);
    mukca_dense_syrk(A, N, X, 80, N);
    for (int k = 1; k <= K; k += 5) {
        memcpy(L, A, sizeof L);
        memcpy(x, b, sizeof x);
        assert_true(mukca_dense_cholesky(L, N));
        mukca_dense_forward(x, k, L, N);
        mukca_dense_backward(x, k, L, N);
        for (int i = 0; i < N; i++)
            for (int c = 0; c < k; c++) {
                double sum = 0;
                for (int j = 0; j < N; j++) sum += A[i * N + j] * x[j * k + c];
                assert_close(sum, b[i * k + c], 1e-10);
            }
    }
    A[7 * N + 7] = -1;
    assert_false(mukca_dense_cholesky(A, N));
    double nan1[4] = {1, 0, 0, NAN};
    assert_false(mukca_dense_cholesky(nan1, 2));
}

/* U' U = I, V' V = I, U S V' = A, s descending. */
static void check_svd(const double *A, int n, double tolerance)
{
    static double U[MAX * MAX], V[MAX * MAX], s[MAX];
    memcpy(U, A, (size_t)(n * n) * sizeof *A);
    assert_true(mukca_dense_svd(U, s, V, n));
    for (int a = 0; a < n; a++)
        for (int b = 0; b < n; b++) {
            double uu = 0, vv = 0;
            for (int i = 0; i < n; i++) uu += U[i * n + a] * U[i * n + b];
            for (int i = 0; i < n; i++) vv += V[i * n + a] * V[i * n + b];
            if (s[a] > 0 && s[b] > 0) assert_close(uu, a == b, 1e-13);
            assert_close(vv, a == b, 1e-13);
        }
    for (int j = 1; j < n; j++) assert_true(s[j] >= 0 && s[j] <= s[j - 1]);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            double sum = 0;
            for (int k = 0; k < n; k++) sum += U[i * n + k] * s[k] * V[j * n + k];
            assert_close(sum, A[i * n + j], tolerance * s[0]);
        }
}

TEST(test_svd)
{
    static double A[MAX * MAX], s[MAX], V[25];
    fill(A, 48 * 48, 7);
    check_svd(A, 48, 1e-14);
    for (int i = 0; i < 48; i++) A[i * 48 + 5] = A[i * 48 + 9]; /* equal columns */
    check_svd(A, 48, 1e-14);
    for (int i = 0; i < 48; i++) A[i * 48 + 7] = 0;
    check_svd(A, 48, 1e-14);
    fill(A, 48 * 48, 8);
    for (int i = 0; i < 48 * 48; i++) A[i] *= pow(10, -(i % 48) * 0.5); /* condition of 1e24 */
    check_svd(A, 48, 1e-14);
    for (int i = 0; i < 144; i++) A[i] = hilbert(i / 12, i % 12);
    check_svd(A, 12, 1e-14);

    /* Known values: the 5 x 5 Hilbert matrix, and a graded diagonal to full relative accuracy. */
    for (int i = 0; i < 25; i++) A[i] = hilbert(i / 5, i % 5);
    assert_true(mukca_dense_svd(A, s, V, 5));
    assert_close(s[0], 1.5670506910982307, 1e-14);
    assert_close(s[4], 3.2879287721718e-06, 1e-16);
    double graded[] = {1e-18, 0, 0, 0, 1, 0, 0, 0, 1e-9};
    assert_true(mukca_dense_svd(graded, s, V, 3));
    assert_close(s[0], 1, 0);
    assert_close(s[1], 1e-9, 1e-24);
    assert_close(s[2], 1e-18, 1e-33);
    double dust[] = {1, 1e-170, 1, 1e-160 + 1e-170}; /* squares underflow, products do not */
    assert_true(mukca_dense_svd(dust, s, V, 2));
    assert_close(s[0], sqrt(2), 1e-15);
    double bad[] = {1, NAN, 2, 3}, huge[] = {1, INFINITY, 2, 3};
    assert_false(mukca_dense_svd(bad, s, V, 2));
    assert_false(mukca_dense_svd(huge, s, V, 2));
}

/* R'R = A'A and the residual, however the rows are cut. */
TEST(test_absorb)
{
    enum { M = 101, N = 13, K = 2, W = N + K };
    static double rows[M * W], block[M * W], R[N * W], first[N * W];
    fill(rows, M * W, 9);
    for (int size = 1; size <= M; size += 10) {
        double rss[K] = {0};
        memset(R, 0, sizeof R);
        for (int r = 0; r < M; r += size) {
            int m = M - r < size ? M - r : size;
            memcpy(block, rows + r * W, (size_t)(m * W) * sizeof *block);
            mukca_dense_qr_absorb(R, block, m, N, K);
            for (int i = 0; i < m * K; i++) {
                const double left = block[i / K * W + N + i % K];
                rss[i % K] += left * left;
            }
        }
        for (int i = 0; i < N; i++)
            for (int j = 0; j < W; j++) {
                double sum = 0, of_r = 0;
                for (int r = 0; r < M; r++) sum += rows[r * W + i] * rows[r * W + j];
                for (int k = 0; k <= i; k++) of_r += R[k * W + i] * R[k * W + j];
                assert_close(of_r, sum, 1e-11);
                if (j < i) assert_close(R[i * W + j], 0, 0);
            }
        for (int c = 0; c < K; c++) {
            double sum = rss[c], all = 0;
            for (int i = 0; i < N; i++) sum += R[i * W + N + c] * R[i * W + N + c];
            for (int r = 0; r < M; r++) all += rows[r * W + N + c] * rows[r * W + N + c];
            assert_close(sum, all, 1e-11);
        }
        if (size == 1) memcpy(first, R, sizeof R);
        for (int i = 0; i < N * W; i++) assert_close(fabs(R[i]), fabs(first[i]), 1e-12);
    }
}

/* Columns whose squares underflow or overflow are rotated all the same. */
TEST(test_scales)
{
    enum { N = 4, M = 6 };
    static const double scale[] = {1e-200, 1e-165, 1, 1e165};
    double A[M * N], R[N * N];
    for (size_t s = 0; s < sizeof scale / sizeof *scale; s++) {
        double plain[N * N] = {0}, first[M * N];
        fill(A, M * N, 77);
        memcpy(first, A, sizeof A);
        mukca_dense_qr_absorb(plain, first, M, N, 0);
        memset(R, 0, sizeof R);
        for (int i = 0; i < M * N; i++) A[i] *= scale[s];
        mukca_dense_qr_absorb(R, A, M, N, 0);
        for (int i = 0; i < N; i++)
            for (int j = 0; j < N; j++)
                if (i != 2)
                    assert_close(fabs(R[i * N + j] / scale[s]), fabs(plain[i * N + j]), 1e-13);
    }
    double triangle[9] = {0}, twin[] = {1, 1, 1e-170, 1, 1, 1e-170 * (1 + 1e-8)}; /* dust of dust */
    mukca_dense_qr_absorb(triangle, twin, 2, 3, 0);
    for (int i = 0; i < 9; i++) assert_true(isfinite(triangle[i]));
}

TEST_MAIN(NULL, NULL)
