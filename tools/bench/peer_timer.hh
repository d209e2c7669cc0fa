// Times of a C++ peer beside the yardstick, as bench_fk.c prints them: all passes in turn, and the
// ratio of each to seven sines of the C library in the same repeat.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

class PeerTimer
{
   public:
    PeerTimer(int repeats, const std::vector<std::vector<double>> &q) : repeats_(repeats), q_(q)
    {
        add("yardstick", [this](std::size_t r) {
            volatile double s, c;  // the sum of the angles' sines would be a pass of another kind
            for (double angle : q_[r]) {
                double sine, cosine;
                sincos(angle, &sine, &cosine);
                s = sine, c = cosine;
            }
            (void)s, (void)c;
        });
    }

    void add(const std::string &name, std::function<void(std::size_t)> row)
    {
        passes_.push_back({name, std::move(row), {}, {}});
    }

    // Prints all but the yardstick.
    void run()
    {
        for (int i = 0; i < repeats_; i++)
            for (Pass &p : passes_) {
                const auto start = std::chrono::steady_clock::now();
                for (std::size_t r = 0; r < q_.size(); r++) p.row(r);
                const std::chrono::duration<double, std::nano> took =
                    std::chrono::steady_clock::now() - start;
                p.times.push_back(took.count() / static_cast<double>(q_.size()));
                p.ratios.push_back(p.times.back() / passes_[0].times.back());
            }
        for (Pass &p : passes_) {
            std::sort(p.times.begin(), p.times.end());
            std::sort(p.ratios.begin(), p.ratios.end());
            const std::size_t n = p.times.size();
            if (&p != &passes_[0])
                std::printf("%s %.6g %.4g %.4g %.4g\n", p.name.c_str(), p.times[n / 2],
                            p.ratios[n / 2], p.ratios[n / 4], p.ratios[3 * n / 4]);
        }
    }

   private:
    struct Pass {
        std::string name;
        std::function<void(std::size_t)> row;
        std::vector<double> times, ratios;
    };
    int repeats_;
    std::vector<std::vector<double>> q_;
    std::vector<Pass> passes_;
};

// Rows of `width` doubles.
inline std::vector<std::vector<double>> read_rows(const char *path, std::size_t width)
{
    std::vector<std::vector<double>> rows;
    std::vector<double> row(width);
    FILE *file = std::fopen(path, "rb");
    while (file && std::fread(row.data(), sizeof(double), width, file) == width)
        rows.push_back(row);
    if (file) std::fclose(file);
    return rows;
}
