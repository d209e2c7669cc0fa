// The arm's chain from a URDF: the tree by urdfdom, exact origins from the text.  The only C++
// file.
#include <console_bridge/console.h>
#include <urdf_model/joint.h>
#include <urdf_model/link.h>
#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <map>
#include <new>
#include <set>
#include <string>
#include <vector>

extern "C" {
#include "base/file.h"
#include "base/number.h"
#include "base/suggest.h"
#include "base/text.h"
#include "io/table.h"
#include "io/urdf.h"
}

namespace
{

// Thrown after the error record is filled; never leaves this file.
struct Failure {
    mukca_status status;
};

// Collects urdfdom's messages instead of printing them; the first is the most specific.
class Listener : public console_bridge::OutputHandler
{
   public:
    Listener() { console_bridge::useOutputHandler(this); }
    ~Listener() override { console_bridge::restorePreviousOutputHandler(); }
    void log(const std::string &text, console_bridge::LogLevel level, const char *, int) override
    {
        if (level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR && first.empty()) first = text;
    }
    std::string first;
};

// Notes failed allocations, which urdfdom reports as bad numbers or omitted elements.
bool exhausted;

void run_out()
{
    exhausted = true;
    throw std::bad_alloc();
}

// "a, b, c", truncated to leave room for the rest of an error message.
std::string join(const std::vector<std::string> &names)
{
    std::string text;
    for (const std::string &name : names) {
        if (text.size() + name.size() > 140) return text + ", ...";
        text += (text.empty() ? "" : ", ") + name;
    }
    return text;
}

std::string one_line(std::string text)
{
    for (char &c : text)
        if (c == '\n' || c == '\t') c = ' ';
    return text.substr(0, 140);
}

struct Loader {
    mukca_chain *chain_;
    const char *path_;
    const mukca_urdf_options &options_;
    mukca_note_fn *note_;
    void *context_;
    mukca_error *error_;
    mukca_urdf_text text_;
    urdf::ModelInterfaceSharedPtr model_;
    std::map<std::string, mukca_mass> masses_;  // by link

    ~Loader()
    {
        mukca_urdf_text_free(&text_);
        if (!model_) return;
        /* links in a cycle own each other and would never be freed */
        for (const auto &entry : model_->links_) entry.second->child_links.clear();
    }

    void run()
    {
        *chain_ = mukca_chain();
        mukca_status status = mukca_urdf_text_read(&text_, path_, error_);
        if (status) throw Failure{status};
        path_ = mukca_file_shown(path_);
        parse();
        check_tree();
        const std::string base = find_base(), tip = find_tip(base);
        read_masses();
        std::vector<std::string> joints = path(base, tip);
        if (joints.size() > MUKCA_MAX_ELEMENTS)
            fail("the chain has " + std::to_string(joints.size()) + " joints, more than " +
                 std::to_string(MUKCA_MAX_ELEMENTS));
        const std::string &robot = model_->getName();
        copy_name(chain_->robot,
                  robot.substr(0, mukca_utf8_fit(robot.c_str(), MUKCA_NAME_SIZE - 1)));
        copy_name(chain_->base, base);
        copy_name(chain_->tip, tip);
        std::snprintf(chain_->urdf_sha256, sizeof chain_->urdf_sha256, "%s", text_.sha256);
        for (const std::string &name : joints) add_element(name);
        if (chain_->n_joints == 0)
            fail("no joint moves between '" + base + "' and '" + tip + "'; check --base and --tip");
        for (int k = 0; k < chain_->n_elements; k++)
            add_mass(k, k + 1 < chain_->n_elements ? chain_->element[k + 1].name : "");
        set_gravity(base);
    }

    [[noreturn]] void fail(const std::string &what, int line = 0)
    {
        const std::string place = line ? std::to_string(line) + ":" : "";
        throw Failure{
            mukca_fail(error_, MUKCA_INPUT, "%s:%s %s", path_, place.c_str(), what.c_str())};
    }

    [[noreturn]] void fail_joint(const std::string &joint, const std::string &what)
    {
        const mukca_urdf_joint *t = mukca_urdf_text_joint(&text_, joint.c_str());
        fail("joint '" + joint + "': " + what, t ? t->line : 0);
    }

    void add_note(const std::string &what)
    {
        mukca_note_format(note_, context_, "%s: %s", path_, what.c_str());
    }

    void copy_name(char *to, const std::string &name)
    {
        if (name.size() >= MUKCA_NAME_SIZE)
            fail("the name '" + name.substr(0, 40) + "...' is longer than 63 characters");
        if (!mukca_utf8_valid(name.c_str()))
            fail("the name '" + name + "' has control characters; rename it in the URDF");
        std::memcpy(to, name.c_str(), name.size() + 1);
    }

    void parse()
    {
        Listener listener;
        exhausted = false;
        std::set_new_handler(run_out);
        model_ = urdf::parseURDF(text_.elements);
        if (exhausted) throw std::bad_alloc();
        if (!model_)
            fail("urdfdom cannot read it: " +
                 one_line(listener.first.empty() ? "no reason given" : listener.first));
        if (!model_->getRoot()) fail("has no root link");
        if (!listener.first.empty())
            add_note("urdfdom skips what it cannot read, perhaps masses: " +
                     one_line(listener.first));
    }

    // Checks that every link is below the root by one joint; urdfdom does not check this.
    void check_tree()
    {
        std::map<std::string, std::string> parent_joint;
        for (const auto &entry : model_->joints_) {
            const urdf::Joint &joint = *entry.second;
            if (!parent_joint.emplace(joint.child_link_name, joint.name).second)
                fail_joint(joint.name, "link '" + joint.child_link_name +
                                           "' is the child of two joints; " +
                                           "a URDF must be a tree");
        }
        std::set<std::string> below;
        std::vector<std::string> open = {model_->getRoot()->name};
        while (!open.empty()) {
            const std::string link = open.back();
            open.pop_back();
            below.insert(link);
            for (const auto &joint : model_->getLink(link)->child_joints)
                open.push_back(joint->child_link_name);
        }
        for (const auto &entry : parent_joint)
            if (!below.count(entry.first))
                fail_joint(entry.second,
                           "link '" + entry.first + "' is part of a cycle; a URDF must be a tree");
    }

    [[noreturn]] void unknown_link(const char *option, const std::string &name)
    {
        std::vector<std::string> names;
        std::string meant;
        int best = 99;
        for (const auto &entry : model_->links_) {
            names.push_back(entry.first);
            if (mukca_suggest_better(&best, name.c_str(), entry.first.c_str())) meant = entry.first;
        }
        fail(std::string("has no link '") + name.substr(0, 60) + "' (" + option + ")" +
             (meant.empty() ? "; links: " + join(names) : "; did you mean " + meant + "?"));
    }

    std::string find_base()
    {
        if (!options_.base) return model_->getRoot()->name;
        if (!model_->links_.count(options_.base)) unknown_link("--base", options_.base);
        return options_.base;
    }

    bool is_below(const std::string &link, const std::string &base) const
    {
        for (urdf::LinkConstSharedPtr at = model_->getLink(link); at; at = at->getParent())
            if (at->name == base) return true;
        return false;
    }

    std::string find_tip(const std::string &base)
    {
        std::vector<std::string> leaves;
        for (const auto &entry : model_->links_)
            if (entry.second->child_joints.empty() && entry.first != base &&
                is_below(entry.first, base))
                leaves.push_back(entry.first);
        if (options_.tip) {
            if (!model_->links_.count(options_.tip)) unknown_link("--tip", options_.tip);
            if (is_below(options_.tip, base) && base != options_.tip) return options_.tip;
            urdf::LinkConstSharedPtr above = model_->getLink(base)->getParent();
            while (above && !is_below(options_.tip, above->name)) above = above->getParent();
            fail("link '" + std::string(options_.tip) + "' (--tip) is not below '" + base +
                 "' (--base)" +
                 (leaves.empty() ? ", and no link is" : "; the ends below it are " + join(leaves)) +
                 (above ? "; for this tip give --base " + above->name : ""));
        }
        for (const char *name : {"ball_link", "ball"})
            if (model_->links_.count(name) && is_below(name, base) && base != name) return name;
        if (leaves.empty()) fail("nothing is below link '" + base + "' (--base)");
        if (leaves.size() > 1) fail("has several ends; choose one with --tip: " + join(leaves));
        return leaves[0];
    }

    std::vector<std::string> path(const std::string &base, const std::string &tip) const
    {
        std::vector<std::string> joints;
        for (std::string link = tip; link != base;) {
            urdf::JointConstSharedPtr joint = model_->getLink(link)->parent_joint;
            joints.insert(joints.begin(), joint->name);
            link = joint->parent_link_name;
        }
        return joints;
    }

    void set_axis(mukca_element *e, const urdf::Joint &joint)
    {
        const double axis[3] = {joint.axis.x, joint.axis.y, joint.axis.z};
        double length = std::sqrt(mukca_dot3(axis, axis));
        if (!(length > 1e-9) || !std::isfinite(length))
            fail_joint(joint.name, "its axis is 0 0 0; set a direction");
        const bool unit = std::fabs(length - 1) <= 1e-15;
        if (std::fabs(length - 1) > 1e-6)
            mukca_note_format(note_, context_,
                              "%s: joint '%s': its axis has length %.6g; normalised", path_,
                              joint.name.c_str(), length);
        for (int i = 0; i < 3; i++) e->axis[i] = unit ? axis[i] : axis[i] / length;
    }

    void set_limits(mukca_element *e, const urdf::Joint &joint)
    {
        if (e->type == MUKCA_CONTINUOUS || !joint.limits) return;
        if (joint.limits->lower < joint.limits->upper) {
            e->lower = joint.limits->lower;
            e->upper = joint.limits->upper;
        } else {
            add_note("joint '" + joint.name +
                     "': its limits are equal or reversed; treated as unlimited");
        }
    }

    // Joint names are column names of recordings and must be readable.
    void check_column(const std::string &name)
    {
        if (name.empty() || name.find_first_of("\t\r\n,\"") != std::string::npos ||
            name[0] == '#' || name.front() == ' ' || name.back() == ' ' ||
            mukca_columns_reserved(name.c_str()))
            fail_joint(name, "its name cannot be the name of a column; rename it in the URDF");
    }

    void add_element(const std::string &name)
    {
        const urdf::Joint &joint = *model_->getJoint(name);
        mukca_element *e = &chain_->element[chain_->n_elements];
        copy_name(e->name, name);
        copy_name(e->child, joint.child_link_name);
        static const std::map<int, mukca_joint_type> types = {
            {urdf::Joint::REVOLUTE, MUKCA_REVOLUTE},
            {urdf::Joint::CONTINUOUS, MUKCA_CONTINUOUS},
            {urdf::Joint::PRISMATIC, MUKCA_PRISMATIC},
            {urdf::Joint::FIXED, MUKCA_FIXED}};
        if (!types.count(joint.type))
            fail_joint(name,
                       "planar and floating joints cannot be in the chain; "
                       "choose --base and --tip on the same side of it");
        e->type = types.at(joint.type);
        if (joint.mimic)
            fail_joint(name, "it mimics '" + joint.mimic->joint_name +
                                 "', which is not supported in the chain; choose another --tip");
        joint_origin(name, e->xyz, e->rpy);
        for (double x : e->xyz)
            if (std::fabs(x) > MUKCA_NUMBER_LARGEST)
                fail_joint(name,
                           "its origin is farther away than any arm reaches; lengths are in m");
        e->joint = -1;
        e->axis[0] = 1;
        e->lower = -HUGE_VAL;
        e->upper = HUGE_VAL;
        if (e->type != MUKCA_FIXED) {
            if (chain_->n_joints == MUKCA_MAX_JOINTS)
                fail("the chain has more than " + std::to_string(MUKCA_MAX_JOINTS) +
                     " joints that move");
            check_column(name);
            set_axis(e, joint);
            set_limits(e, joint);
            e->joint = chain_->n_joints;
            chain_->joint_element[chain_->n_joints++] = chain_->n_elements;
        }
        chain_->n_elements++;
    }

    // The origin as written: urdfdom stores a quaternion and loses rpy near +-90 degrees.
    mukca_frame joint_origin(const std::string &name, double xyz[3], double rpy[3]) const
    {
        mukca_frame frame;
        const mukca_urdf_joint *t = mukca_urdf_text_joint(&text_, name.c_str());
        for (int i = 0; i < 3; i++) {
            xyz[i] = t ? t->xyz[i] : 0;
            rpy[i] = t ? t->rpy[i] : 0;
            frame.p[i] = xyz[i];
        }
        mukca_rotation_from_rpy(frame.R, rpy);
        return frame;
    }

    // The link of a row of --inertials, whose name may lack an arm's prefix ("panda_").
    std::string find_link(const char *name)
    {
        std::string found;
        if (model_->links_.count(name)) return name;
        for (const auto &entry : model_->links_) {
            if (!mukca_prefix_ends(entry.first.c_str(), name)) continue;
            if (!found.empty())
                fail(std::string("links '") + found + "' and '" + entry.first + "' are both a '" +
                     name + "'; write whole names into the file of --inertials");
            found = entry.first;
        }
        if (found.empty()) unknown_link(options_.inertials, name);
        return found;
    }

    void read_masses()
    {
        for (const auto &entry : model_->links_) {
            const urdf::InertialSharedPtr &inertial = entry.second->inertial;
            if (!inertial) continue;
            if (!(inertial->mass >= 0) || !std::isfinite(inertial->mass))
                fail("link '" + entry.first + "': its mass is negative");
            const urdf::Vector3 &p = inertial->origin.position;
            for (double value : {inertial->mass, p.x, p.y, p.z})
                if (!(std::fabs(value) <= MUKCA_NUMBER_LARGEST))
                    fail("link '" + entry.first +
                         "': its mass or centre of mass is larger than any arm's");
            mukca_mass &mass = masses_[entry.first];
            mass = {0, inertial->mass, {p.x, p.y, p.z}, {0}};
            const double I[6] = {inertial->ixx, inertial->iyy, inertial->izz,
                                 inertial->ixy, inertial->ixz, inertial->iyz};
            const urdf::Rotation &r = inertial->origin.rotation; /* getRPY is inexact near 90 deg */
            const double quaternion[4] = {r.w, r.x, r.y, r.z};
            double R[9];
            mukca_rotation_from_quaternion(R, quaternion);
            add_turned(mass.inertia, R, I);
        }
        if (options_.inertials) replace_masses();
    }

    // The rows of the table of --inertials.
    void replace_masses()
    {
        static const char *const names[] = {"link", "mass_kg", "com_x_m", "com_y_m", "com_z_m"};
        struct Open {
            mukca_table table;
            ~Open() { mukca_table_close(&table); }
        } open;
        mukca_table *t = &open.table;
        std::set<std::string> seen;
        int column[5];
        double value[5];
        mukca_table_open(t, options_.inertials, MUKCA_HEADER, error_);
        for (int i = 0; i < 5; i++) column[i] = mukca_table_require(t, names[i]);
        while (mukca_table_next(t)) {
            const char *link = t->cell[column[0]];
            for (int i = 1; i < 5; i++) {
                value[i] = mukca_table_number(t, column[i]);
                if (std::fabs(value[i]) > MUKCA_NUMBER_LARGEST)
                    mukca_table_fail(t, column[i],
                                     "%g is larger than any arm's; masses are in kg, lengths in m",
                                     value[i]);
            }
            if (value[1] < 0) mukca_table_fail(t, column[1], "a mass cannot be negative");
            if (!seen.insert(link).second)
                mukca_table_fail(t, column[0], "link '%s' has a row already", link);
            if (t->status == MUKCA_OK)
                masses_[find_link(link)] = {0, value[1], {value[2], value[3], value[4]}, {0}};
        }
        if (t->status) throw Failure{t->status};
    }

    // Add R I R' to sum; tensors are xx yy zz xy xz yz.
    static void add_turned(double sum[6], const double R[9], const double I[6])
    {
        const int at[3][3] = {{0, 3, 4}, {3, 1, 5}, {4, 5, 2}};
        for (int a = 0; a < 3; a++)
            for (int b = a; b < 3; b++)
                for (int i = 0; i < 3; i++)
                    for (int j = 0; j < 3; j++)
                        sum[at[a][b]] += R[3 * a + i] * I[at[i][j]] * R[3 * b + j];
    }

    // Add the tensor of a point mass at p.
    static void add_point(double sum[6], double kg, const double p[3])
    {
        for (int a = 0; a < 3; a++) {
            sum[a] += kg * (mukca_dot3(p, p) - p[a] * p[a]);
            sum[3 + a] -= kg * p[a > 1] * p[1 + (a > 0)];
        }
    }

    // Sum kg, kg * com and the tensor about the element's frame of `link` and its descendants
    // except beyond the joint `next`; T is its pose in that frame.
    void fold(double *kg, double moment[3], double inertia[6], const std::string &link,
              const mukca_frame &T, const std::string &next) const
    {
        auto mass = masses_.find(link);
        if (mass != masses_.end()) {
            double p[3];
            mukca_mat3_vec(p, T.R, mass->second.com);
            *kg += mass->second.kg;
            for (int i = 0; i < 3; i++) moment[i] += mass->second.kg * (p[i] += T.p[i]);
            add_turned(inertia, T.R, mass->second.inertia);
            add_point(inertia, mass->second.kg, p);
        }
        for (const auto &joint : model_->getLink(link)->child_joints) {
            if (joint->name == next) continue;
            double xyz[3], rpy[3];
            mukca_frame origin = joint_origin(joint->name, xyz, rpy), child;
            mukca_frame_multiply(&child, &T, &origin);
            fold(kg, moment, inertia, joint->child_link_name, child, next);
        }
    }

    void add_mass(int element, const std::string &next)
    {
        const mukca_frame identity = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
        double kg = 0, moment[3] = {0, 0, 0}, inertia[6] = {0};
        fold(&kg, moment, inertia, chain_->element[element].child, identity, next);
        if (kg == 0) return;
        mukca_mass *m = &chain_->mass[chain_->n_masses++];
        m->element = element;
        m->kg = kg;
        for (int i = 0; i < 3; i++) m->com[i] = moment[i] / kg;
        add_point(inertia, -kg, m->com);
        std::memcpy(m->inertia, inertia, sizeof m->inertia);
    }

    void set_gravity(const std::string &base)
    {
        const double *given = options_.gravity;
        std::memcpy(chain_->gravity, given, sizeof chain_->gravity);
        if (mukca_dot3(given, given) > 0) return;
        mukca_frame T = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
        bool moves = false;
        for (const std::string &name : path(model_->getRoot()->name, base)) {
            double xyz[3], rpy[3];
            mukca_frame origin = joint_origin(name, xyz, rpy);
            mukca_frame_multiply(&T, &T, &origin);
            moves |= model_->getJoint(name)->type != urdf::Joint::FIXED;
        }
        const double down[3] = {0, 0, -9.80665};
        mukca_mat3_tvec(chain_->gravity, T.R, down);
        if (moves)
            add_note("joints above '" + base +
                     "' are assumed at zero for the direction of gravity; or give --gravity");
    }
};

}  // namespace

extern "C" mukca_status mukca_urdf_load(mukca_chain *chain, const char *path,
                                        const mukca_urdf_options *options, mukca_note_fn *note,
                                        void *context, mukca_error *error)
{
    const mukca_urdf_options defaults = {};
    try {
        Loader{chain, path, options ? *options : defaults, note, context, error, {}, nullptr, {}}
            .run();
        return MUKCA_OK;
    } catch (const Failure &failure) {
        return failure.status;
    } catch (const std::bad_alloc &) {
        return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    } catch (const std::exception &e) {
        return mukca_fail(error, MUKCA_INPUT, "%s: cannot be read: %s", mukca_file_shown(path),
                          e.what());
    } catch (...) {
        return mukca_fail(error, MUKCA_INPUT, "%s: cannot be read", mukca_file_shown(path));
    }
}
