// Times of a C++ peer beside the yardstick, as bench_fk.c prints them: all passes in turn over the
// next rows of the file, and the ratio of each to seven sines of the C library in the same repeat.
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
    static constexpr std::size_t rows = 1000;  // of a repeat, as in bench_fk.c
    std::vector<std::vector<double>> q;        // the repeat's rows of joint angles
    std::vector<double> tips;                  // the positions that a peer finds for them

    PeerTimer(const char *path, int joints)
        : q(rows, std::vector<double>(static_cast<std::size_t>(joints))),
          tips(3 * rows),
          path_(path)
    {
        add("yardstick", [this](std::size_t r) {
            for (double angle : q[r]) sincos(angle, &tips[0], &tips[1]);
        });
    }

    void add(const std::string &name, std::function<void(std::size_t)> row)
    {
        passes_.push_back({name, std::move(row), {}, {}});
    }

    // Prints all but the yardstick.
    void run()
    {
        std::FILE *file = std::fopen(path_, "rb");
        while (file && next(file))
            for (Pass &p : passes_) {
                const auto start = std::chrono::steady_clock::now();
                for (std::size_t r = 0; r < rows; r++) p.row(r);
                const std::chrono::duration<double, std::nano> took =
                    std::chrono::steady_clock::now() - start;
                p.times.push_back(took.count() / static_cast<double>(rows));
                p.ratios.push_back(p.times.back() / passes_[0].times.back());
            }
        if (file) std::fclose(file);
        for (Pass &p : passes_) {
            std::sort(p.times.begin(), p.times.end());
            std::sort(p.ratios.begin(), p.ratios.end());
            const std::size_t n = p.times.size();
            if (&p != &passes_[0] && n > 0)
                std::printf("%s %.6g %.4g %.4g %.4g\n", p.name.c_str(), p.times[n / 2],
                            p.ratios[n / 2], p.ratios[n / 4], p.ratios[3 * n / 4]);
        }
        double sum[3] = {0, 0, 0};
        for (std::size_t i = 0; i < tips.size(); i++) sum[i % 3] += tips[i];
        std::printf("check %.12g %.12g %.12g\n", sum[0], sum[1], sum[2]);
    }

   private:
    struct Pass {
        std::string name;
        std::function<void(std::size_t)> row;
        std::vector<double> times, ratios;
    };
    const char *path_;
    std::vector<Pass> passes_;

    bool next(std::FILE *file)
    {
        for (auto &row : q)
            if (std::fread(row.data(), sizeof(double), row.size(), file) != row.size())
                return false;
        return true;
    }
};
