#pragma once

#include <memory>
#include <utility>

#include "brdf/albedo.h"
#include "brdf/brdf.h"

namespace micro {

/// Any model that was chosen while the program runs. Copies share it.
class AnyBrdf {
 public:
  template <Brdf Model>
  requires(!std::same_as<Model, AnyBrdf>) explicit AnyBrdf(Model model)
      : model_(std::make_shared<Holder<Model>>(std::move(model))) {}

  double f(const Vec3& wi, const Vec3& wo, double lambda_um) const { return model_->f(wi, wo, lambda_um); }
  std::optional<BrdfSample> sample(const Vec3& wi, double lambda_um, const Vec2& xi) const {
    return model_->sample(wi, lambda_um, xi);
  }
  double pdf(const Vec3& wi, const Vec3& wo, double lambda_um) const {
    return model_->pdf(wi, wo, lambda_um);
  }
  Estimate<double> albedo(const Vec3& wi, double lambda_um, double tolerance) const {
    return model_->albedo(wi, lambda_um, tolerance);
  }

 private:
  struct Interface {
    virtual ~Interface() = default;
    virtual double f(const Vec3& wi, const Vec3& wo, double lambda_um) const = 0;
    virtual std::optional<BrdfSample> sample(const Vec3& wi, double lambda_um, const Vec2& xi) const = 0;
    virtual double pdf(const Vec3& wi, const Vec3& wo, double lambda_um) const = 0;
    virtual Estimate<double> albedo(const Vec3& wi, double lambda_um, double tolerance) const = 0;
  };
  template <typename Model>
  struct Holder final : Interface {
    explicit Holder(Model m) : model(std::move(m)) {}
    double f(const Vec3& wi, const Vec3& wo, double lambda_um) const override {
      return model.f(wi, wo, lambda_um);
    }
    std::optional<BrdfSample> sample(const Vec3& wi, double lambda_um, const Vec2& xi) const override {
      return model.sample(wi, lambda_um, xi);
    }
    double pdf(const Vec3& wi, const Vec3& wo, double lambda_um) const override {
      return model.pdf(wi, wo, lambda_um);
    }
    Estimate<double> albedo(const Vec3& wi, double lambda_um, double tolerance) const override {
      return micro::albedo(model, wi, lambda_um, tolerance);
    }
    Model model;
  };

  std::shared_ptr<const Interface> model_;
};
static_assert(Brdf<AnyBrdf>);

}  // namespace micro
