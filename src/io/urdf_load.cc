// The arm's chain from a URDF's tree: elements and the masses that they carry.  The only C++ file.
#include <cmath>

extern "C" {
#include "base/number.h"
#include "io/table.h"
#include "io/urdf.h"
#include "mukca/gravity.h"
}
#include "io/urdf_tree.h"

namespace
{

struct Loader : Tree {
    mukca_chain *chain_;
    std::map<std::string, mukca_mass> masses_;  // by link

    void run()
    {
        *chain_ = mukca_chain();
        read();
        const std::string base = find_base(), tip = find_tip(base);
        read_masses();
        std::vector<std::string> joints = path(base, tip);
        if (joints.size() > MUKCA_MAX_ELEMENTS)
            fail("the chain has " + std::to_string(joints.size()) + " joints, more than " +
                 std::to_string(MUKCA_MAX_ELEMENTS));
        const std::string &robot = model_->getName();
        const std::size_t length = mukca_utf8_fit(robot.c_str(), MUKCA_NAME_SIZE - 1);
        copy_name(chain_->robot, mukca_utf8_valid(robot.c_str()) ? robot.substr(0, length) : robot);
        copy_name(chain_->base, base);
        copy_name(chain_->tip, tip);
        std::snprintf(chain_->urdf_sha256, sizeof chain_->urdf_sha256, "%s", text_.sha256);
        for (const std::string &name : joints) add_element(name);
        if (chain_->n_joints == 0)
            fail("no joint moves between '" + base + "' and '" + tip + "'; check --base and --tip");
        fold_masses();
        set_gravity(base);
    }

    void copy_name(char *to, const std::string &name)
    {
        if (name.size() >= MUKCA_NAME_SIZE)
            fail("the name '" + name.substr(0, 40) + "...' is longer than 63 characters");
        if (!mukca_utf8_valid(name.c_str()))
            fail("the name '" + name + "' has control characters; rename it in the URDF");
        std::memcpy(to, name.c_str(), name.size() + 1);
    }

    void set_axis(mukca_element *e, const urdf::Joint &joint)
    {
        const double axis[3] = {joint.axis.x, joint.axis.y, joint.axis.z};
        double length = std::sqrt(mukca_dot3(axis, axis));
        if (!(length > 1e-9) || !std::isfinite(length))
            fail_joint(joint.name, "its axis is 0 0 0; set a direction");
        const bool unit = std::fabs(length - 1) <= 1e-15;
        if (std::fabs(length - 1) > 1e-6)
            mukca_note_format(options_.notes,
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
        const mukca_urdf_joint origin = written(name);
        std::memcpy(e->xyz, origin.xyz, sizeof e->xyz);
        std::memcpy(e->rpy, origin.rpy, sizeof e->rpy);
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
            const mukca_mass own = {0,
                                    inertial->mass,
                                    {0},
                                    {inertial->ixx, inertial->iyy, inertial->izz, inertial->ixy,
                                     inertial->ixz, inertial->iyz}};
            const urdf::Rotation &turn = inertial->origin.rotation; /* getRPY loses 2 mrad */
            const double quaternion[4] = {turn.w, turn.x, turn.y, turn.z};
            mukca_frame T = {{0}, {p.x, p.y, p.z}};
            mukca_rotation_from_quaternion(T.R, quaternion);
            mukca_body_add(&masses_[entry.first], &T, &own);
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

    // Add the masses of a link and its descendants except beyond the joint `next`; T is its pose.
    void fold(mukca_mass *sum, const std::string &link, const mukca_frame &T,
              const std::string &next) const
    {
        auto mass = masses_.find(link);
        if (mass != masses_.end()) mukca_body_add(sum, &T, &mass->second);
        for (const auto &joint : model_->getLink(link)->child_joints) {
            if (joint->name == next) continue;
            mukca_frame origin = joint_origin(joint->name), child;
            mukca_frame_multiply(&child, &T, &origin);
            fold(sum, joint->child_link_name, child, next);
        }
    }

    void fold_masses()
    {
        const mukca_frame identity = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
        for (int k = 0; k < chain_->n_elements; k++) {
            mukca_mass *sum = &chain_->mass[chain_->n_masses];
            sum->element = k;
            fold(sum, chain_->element[k].child, identity,
                 k + 1 < chain_->n_elements ? chain_->element[k + 1].name : "");
            chain_->n_masses += sum->kg > 0;
        }
        if (chain_->n_masses < MUKCA_MAX_MASSES) chain_->mass[chain_->n_masses] = mukca_mass();
    }

    void set_gravity(const std::string &base)
    {
        const double *given = options_.gravity;
        std::memcpy(chain_->gravity, given, sizeof chain_->gravity);
        if (mukca_dot3(given, given) > 0) return;
        mukca_frame T = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
        bool moves = false;
        for (const std::string &name : path(model_->getRoot()->name, base)) {
            const mukca_frame origin = joint_origin(name);
            mukca_frame_multiply(&T, &T, &origin);
            moves |= model_->getJoint(name)->type != urdf::Joint::FIXED;
        }
        const double down[3] = {0, 0, -MUKCA_GRAVITY};
        mukca_mat3_tvec(chain_->gravity, T.R, down);
        if (moves)
            add_note("joints above '" + base +
                     "' are assumed at zero for the direction of gravity; or give --gravity");
    }
};

}  // namespace

extern "C" mukca_status mukca_urdf_load(mukca_chain *chain, const char *path,
                                        const mukca_urdf_options *options, mukca_error *error)
{
    const mukca_urdf_options defaults = {};
    try {
        Loader{{path, options ? *options : defaults, error, {}, nullptr}, chain, {}}.run();
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
