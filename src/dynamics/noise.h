/* Noise of the torque of one joint: AR(1), its coefficient, whitening, standard deviation.
 *
 * Rows are those of one joint: x[rows][ld], row-major, ld the distance between successive times.
 * A piece is a run, or what lies between two gaps of it; noise of different pieces is independent.
 */
#ifndef MUKCA_DYNAMICS_NOISE_H
#define MUKCA_DYNAMICS_NOISE_H

typedef struct {
    int n;
    const int *first; /* [n + 1] first row of each piece, and the number of all rows */
} mukca_pieces;

/* Correlation of successive values of the residual e, e[row * ld], within pieces (Yule-Walker:
 * sum e_t e_t+1 / sum e_t^2 over pairs), limited to [0, most]; 0 without pairs or signal. */
double mukca_ar1_coefficient(const double *e, int ld, const mukca_pieces *pieces, double most);

/* Whiten the first `width` columns in place: x_t - rho x_t-1; the first row of a piece is
 * multiplied by sqrt(1 - rho^2), so that white noise of the same sigma remains. */
void mukca_ar1_whiten(double *x, int width, int ld, const mukca_pieces *pieces, double rho);

/* Log determinant of that whitening, which belongs to the log evidence when rho is compared. */
double mukca_ar1_log_determinant(const mukca_pieces *pieces, double rho);

/* Standard deviation of whitened residuals e[row * ld] with `unknowns` fitted parameters:
 * sqrt(sum e^2 / (rows - unknowns)); at least one degree of freedom. */
double mukca_noise_sigma(const double *e, int ld, int rows, double unknowns);

#endif
