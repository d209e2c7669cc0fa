// A URDF as a tree: urdfdom's model, checked; base and tip; exact origins.  C++.
#ifndef MUKCA_IO_URDF_TREE_H
#define MUKCA_IO_URDF_TREE_H

#include <console_bridge/console.h>
#include <urdf_model/joint.h>
#include <urdf_model/link.h>
#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

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
#include "base/suggest.h"
#include "base/text.h"
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

struct Tree {
    const char *path_;
    const mukca_urdf_options &options_;
    mukca_error *error_;
    mukca_urdf_text text_;
    urdf::ModelInterfaceSharedPtr model_;

    ~Tree()
    {
        mukca_urdf_text_free(&text_);
        if (!model_) return;
        /* links in a cycle own each other and would never be freed */
        for (const auto &entry : model_->links_) entry.second->child_links.clear();
    }

    void read()
    {
        const mukca_status status = mukca_urdf_text_read(&text_, path_, error_);
        if (status) throw Failure{status};
        path_ = mukca_file_shown(path_);
        parse();
        check_tree();
    }

    [[noreturn]] void fail(const std::string &what, int line = 0)
    {
        const std::string place = line ? std::to_string(line) + ":" : "";
        throw Failure{
            mukca_fail(error_, MUKCA_INPUT, "%s:%s %s", path_, place.c_str(), what.c_str())};
    }

    [[noreturn]] void fail_joint(const std::string &joint, const std::string &what)
    {
        fail("joint '" + joint + "': " + what, written(joint).line);
    }

    void add_note(const std::string &what)
    {
        mukca_note_format(options_.notes, "%s: %s", path_, what.c_str());
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

    // The joint as written: urdfdom stores a quaternion and loses rpy near +-90 degrees.
    mukca_urdf_joint written(const std::string &name) const
    {
        const mukca_urdf_joint *t = mukca_urdf_text_joint(&text_, name.c_str());
        return t ? *t : mukca_urdf_joint();
    }

    mukca_frame joint_origin(const std::string &name) const
    {
        const mukca_urdf_joint t = written(name);
        mukca_frame frame = {{0}, {t.xyz[0], t.xyz[1], t.xyz[2]}};
        mukca_rotation_from_rpy(frame.R, t.rpy);
        return frame;
    }
};

}  // namespace

#endif
