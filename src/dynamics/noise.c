/* AR(1) noise of one joint's torque. */
#include "dynamics/noise.h"

#include <math.h>
#include <stddef.h>

double mukca_ar1_coefficient(const double *e, int ld, const mukca_pieces *pieces, double most)
{
    double products = 0, squares = 0;
    for (int i = 0; i < pieces->n; i++)
        for (int r = pieces->first[i]; r + 1 < pieces->first[i + 1]; r++) {
            const double now = e[(size_t)r * (size_t)ld], next = e[(size_t)(r + 1) * (size_t)ld];
            products += now * next;
            squares += now * now;
        }
    return squares > 0 ? fmin(fmax(products / squares, 0), most) : 0;
}

void mukca_ar1_whiten(double *x, int width, int ld, const mukca_pieces *pieces, double rho)
{
    const double start = sqrt(1 - rho * rho);
    for (int i = 0; i < pieces->n; i++)
        for (int r = pieces->first[i + 1] - 1; r >= pieces->first[i]; r--) {
            double *row = x + (size_t)r * (size_t)ld;
            if (r > pieces->first[i])
                for (int c = 0; c < width; c++) row[c] -= rho * row[c - ld];
            else
                for (int c = 0; c < width; c++) row[c] *= start;
        }
}

double mukca_ar1_log_determinant(const mukca_pieces *pieces, double rho)
{
    int started = 0;
    for (int i = 0; i < pieces->n; i++) started += pieces->first[i + 1] > pieces->first[i];
    return 0.5 * started * log1p(-rho * rho);
}

double mukca_noise_sigma(const double *e, int ld, int rows, double unknowns)
{
    double squares = 0;
    for (int r = 0; r < rows; r++) squares += e[(size_t)r * (size_t)ld] * e[(size_t)r * (size_t)ld];
    return sqrt(squares / fmax(rows - unknowns, 1));
}
