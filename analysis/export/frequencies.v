(* ---- Complex numbers and polynomials with real coefficients, the highest first ---- *)

Definition C : Type := (R * R)%type.
Definition cadd (a b : C) : C := (fst a + fst b, snd a + snd b).
Definition cmul (a b : C) : C := (fst a * fst b - snd a * snd b, fst a * snd b + snd a * fst b).
Definition conj_ (a : C) : C := (fst a, - snd a).
Definition re (a : C) : R := fst a.
Definition real (x : R) : C := (x, 0).
Fixpoint cpow (a : C) (n : nat) : C := match n with O => (1, 0) | S k => cmul a (cpow a k) end.
Definition square (a : C) : R := fst a * fst a + snd a * snd a.
Fixpoint horner (acc : C) (p : list R) (s : C) : C :=
  match p with [] => acc | c :: r => horner (cadd (cmul acc s) (real c)) r s end.
Definition poly (p : list R) (s : C) : C := horner (0, 0) p s.
(* den + g num, the denominator of the loop with the gain g. *)
Definition closed (num den : list R) (g : R) (s : C) : C := cadd (poly den s) (cmul (real g) (poly num s)).

(* den(d/dt) xi and num(d/dt) xi, where xi k is the k-th derivative; in discrete time with shifts. *)
Fixpoint along (p : list R) (xi : nat -> R -> R) (t : R) : R :=
  match p with [] => 0 | c :: r => c * xi (length r) t + along r xi t end.
Fixpoint shifts (p : list R) (xi : nat -> R) (t : nat) : R :=
  match p with [] => 0 | c :: r => c * xi (length r + t)%nat + shifts r xi t end.
Definition flow_of (num den : list R) (phi : R -> R) (xi : nat -> R -> R) : Prop :=
  (forall k t, (S k < length den)%nat -> 0 < t -> derivable_pt_lim (xi k) t (xi (S k) t)) /\
  (forall t, 0 < t -> along den xi t = - phi (along num xi t)).
Definition steps_of (num den : list R) (phi : R -> R) (xi : nat -> R) : Prop :=
  forall t, shifts den xi t = - phi (shifts num xi t).

(* ---- Roots, by Lyapunov's equation ---- *)

Definition in_left_half_plane (f : C -> C) : Prop := forall s, f s = (0, 0) -> fst s < 0.
Definition in_unit_disc (f : C -> C) : Prop := forall z, f z = (0, 0) -> square z < 1.

Definition stable_test (discrete : bool) (n : nat) (P now next : list (list Z)) (den : list Z) (kappa N : Z) : bool :=
  (0 <? N)%Z && nonneg n (bilinear P now now) &&
  nonneg n (times N ((if discrete then bilinear P now now ++ times (-1) (bilinear P next next)
                      else times (-1) (bilinear P now next ++ bilinear P next now))
                     ++ [(kappa, (den, den))]) ++ times (-1) (squares now)).

(* a and b hold the real and the imaginary parts of 1, s, s^2, ..; [now] leaves out the last, [next] the first. *)
Lemma roots : forall discrete n P now next den kappa N a b s,
  stable_test discrete n P now next den kappa N = true -> length a = n -> length b = n ->
  dot den a = 0 -> dot den b = 0 -> (exists f, In f now /\ dot f a = 1) ->
  at_ next a = lcomb (fst s) (- snd s) (at_ now a) (at_ now b) ->
  at_ next b = lcomb (fst s) (snd s) (at_ now b) (at_ now a) ->
  if discrete then square s < 1 else fst s < 0.
Proof.
  intros discrete n P now next den kappa N a b [x y] test la lb da db [f [If fa]] na nb; simpl in na, nb.
  unfold stable_test in test; rewrite !andb_true_iff, Z.ltb_lt in test; destruct test as [[pos low] falls].
  apply IZR_lt in pos.
  assert (La := nonneg_sound n _ a low la); assert (Lb := nonneg_sound n _ b low lb).
  assert (Fa := nonneg_sound n _ a falls la); assert (Fb := nonneg_sound n _ b falls lb).
  assert (one : 1 <= value (squares now) a) by (pose proof (squares_in now f a If) as H; rewrite fa in H; lra).
  pose proof (squares_nonneg now b) as two.
  assert (E : length (at_ now a) = length (at_ now b)) by (unfold at_; now rewrite !map_length).
  destruct discrete; rewrite !value_app, !value_times, !value_app, !value_times in Fa, Fb;
    try rewrite !value_app in Fa, Fb;
    cbn [value] in Fa, Fb; rewrite ?da, ?db, !value_bilinear in Fa, Fb; rewrite value_bilinear in La, Lb;
    rewrite na in Fa; rewrite nb in Fb;
    rewrite ?sumprod_left, ?sumprod_right in Fa, Fb by (rewrite ?lcomb_length; lia);
    rewrite ?sumprod_left in Fa, Fb by (rewrite ?lcomb_length; lia);
    set (u := at_ now a) in *; set (v := at_ now b) in *;
    set (uu := sumprod u (map (fun r => dot r u) P)) in *; set (vv := sumprod v (map (fun r => dot r v) P)) in *;
    set (uv := sumprod u (map (fun r => dot r v) P)) in *; set (vu := sumprod v (map (fun r => dot r u) P)) in *.
  - unfold square; simpl fst; simpl snd.
    assert (T : 1 <= IZR N * ((1 - (x * x + y * y)) * (uu + vv))) by nra.
    destruct (Rlt_or_le (x * x + y * y) 1) as [L|L]; [exact L|exfalso].
    assert ((1 - (x * x + y * y)) * (uu + vv) <= 0) by nra; nra.
  - simpl; assert (T : 1 <= IZR N * (- (2 * x) * (uu + vv))) by nra.
    destruct (Rlt_or_le x 0) as [L|L]; [exact L|exfalso].
    assert (- (2 * x) * (uu + vv) <= 0) by nra; nra.
Qed.

(* ---- Positive polynomials, the lowest coefficient first, on [0, inf): by signs, or on either side of a / b ---- *)

Fixpoint peval (p : list Z) (x : R) : R := match p with a :: p' => IZR a + x * peval p' x | [] => 0 end.
Fixpoint shift (p : list Z) : list Z :=
  match p with a :: p' => let q := shift p' in add (a :: q) q | [] => [] end.
(* b^n p(x a / b) *)
Fixpoint stretch (a : Z) (p : list Z) (power : Z) : list Z :=
  match p with c :: p' => (c * power)%Z :: stretch a p' (power * a) | [] => [] end.
Fixpoint pmul (p q : list Z) : list Z := match p with a :: p' => add (scale a q) (0%Z :: pmul p' q) | [] => [] end.
Inductive tree := Signs | Split (a b : Z) (below beyond : tree).
Fixpoint positive (p : list Z) (t : tree) : bool :=
  match t with
  | Signs => match p with a :: p' => (0 <? a)%Z && forallb (Z.leb 0) p' | [] => false end
  | Split a b below beyond =>
      (0 <? a)%Z && (0 <? b)%Z &&
      (let q := stretch a (rev (stretch b (rev p) 1)) 1 in
       (0 <? hd 0%Z q)%Z && positive (shift (rev q)) below && positive (shift q) beyond)
  end.

Lemma peval_add : forall p q x, peval (add p q) x = peval p x + peval q x.
Proof.
  induction p as [|a p IH]; intros [|b q] x; simpl; try lra; rewrite IH, plus_IZR; ring.
Qed.
Lemma peval_scale : forall c p x, peval (scale c p) x = IZR c * peval p x.
Proof. intros c p x; induction p as [|a p IH]; cbn [scale map peval]; [ring|]; fold (scale c p); rewrite IH, mult_IZR; ring. Qed.
Lemma peval_shift : forall p x, peval (shift p) x = peval p (x + 1).
Proof.
  induction p as [|a p IH]; intro x; [reflexivity|].
  cbn [shift]; rewrite peval_add; cbn [peval]; rewrite IH; ring.
Qed.
Lemma peval_mul : forall p q x, peval (pmul p q) x = peval p x * peval q x.
Proof.
  induction p as [|a p IH]; intros q x; cbn [pmul peval]; [ring|].
  rewrite peval_add, peval_scale; cbn [peval]; rewrite IH; ring.
Qed.
Lemma peval_stretch : forall a p power x, peval (stretch a p power) x = IZR power * peval p (IZR a * x).
Proof.
  intros a; induction p as [|c p IH]; intros power x; simpl; [ring|].
  rewrite IH, !mult_IZR; ring.
Qed.
Lemma peval_snoc : forall p c x, peval (p ++ [c]) x = peval p x + IZR c * x ^ length p.
Proof. induction p as [|a p IH]; intros c x; simpl; [ring|]; rewrite IH; ring. Qed.
Lemma peval_turned : forall p x y, x * y = 1 -> x * peval p x = x ^ length p * peval (rev p) y.
Proof.
  intros p x y E; induction p as [|a p IH]; simpl; [ring|].
  rewrite peval_snoc, rev_length.
  assert (P : x ^ length p * y ^ length p = 1) by (rewrite <- Rpow_mult_distr, E, pow1; reflexivity).
  replace (x * x ^ length p * (peval (rev p) y + IZR a * y ^ length p))
    with (x * (x ^ length p * peval (rev p) y) + x * IZR a * (x ^ length p * y ^ length p)) by ring.
  rewrite <- IH, P; ring.
Qed.
Lemma peval_signs : forall p x, forallb (Z.leb 0) p = true -> 0 <= x -> 0 <= peval p x.
Proof.
  induction p as [|a p IH]; intros x H X; simpl in *; [lra|].
  apply andb_true_iff in H as [A H]; apply Z.leb_le, IZR_le in A; specialize (IH x H X); nra.
Qed.
Lemma positive_sound : forall t p x, positive p t = true -> 0 <= x -> 0 < peval p x.
Proof.
  induction t as [|a b below IHb beyond IHe]; intros p x H X.
  - destruct p as [|c p]; [discriminate|]; simpl in H; apply andb_true_iff in H as [A H].
    apply Z.ltb_lt, IZR_lt in A; pose proof (peval_signs p x H X); simpl; nra.
  - cbn [positive] in H; rewrite !andb_true_iff, !Z.ltb_lt in H; destruct H as [[A B] [[Z0 H1] H2]].
    set (q := stretch a (rev (stretch b (rev p) 1)) 1) in *.
    apply IZR_lt in A, B, Z0.
    assert (Q : forall w, 0 <= w -> 0 < peval q w).
    { intros w W; destruct (Rle_or_lt 1 w) as [L|L].
      - replace w with (w - 1 + 1) by ring; rewrite <- peval_shift; apply IHe; [exact H2|lra].
      - destruct W as [W| <-].
        + assert (E : w * / w = 1) by (field; lra).
          pose proof (peval_turned q w (/ w) E) as T.
          assert (V : 1 < / w) by (rewrite <- Rinv_1; apply Rinv_lt_contravar; lra).
          assert (0 < peval (rev q) (/ w)).
          { replace (/ w) with (/ w - 1 + 1) by ring; rewrite <- peval_shift; apply IHb; [exact H1|lra]. }
          assert (0 < w ^ length q) by (apply pow_lt; exact W); nra.
        + destruct q as [|c q']; simpl in *; lra. }
    (* p(x) is a positive multiple of q(w), x = w a / b *)
    set (w := x * IZR b / IZR a).
    assert (W : 0 <= w) by (unfold w, Rdiv; apply Rmult_le_pos; [nra|left; now apply Rinv_0_lt_compat]).
    pose proof (Q w W) as Qw; unfold q in Qw; rewrite peval_stretch in Qw.
    replace (IZR a * w) with (IZR b * x) in Qw by (unfold w; field; lra).
    destruct X as [X| <-].
    + assert (E1 : IZR b * x * / (IZR b * x) = 1) by (field; split; lra).
      assert (E2 : x * / x = 1) by (field; lra).
      pose proof (peval_turned (rev (stretch b (rev p) 1)) (IZR b * x) (/ (IZR b * x)) E1) as T1.
      rewrite rev_involutive, peval_stretch in T1.
      replace (IZR b * / (IZR b * x)) with (/ x) in T1 by (field; split; lra).
      pose proof (peval_turned p x (/ x) E2) as T2.
      assert (0 < IZR b * x) by nra.
      assert (L1 : 0 < (IZR b * x) ^ length (rev (stretch b (rev p) 1))) by (apply pow_lt; assumption).
      assert (L2 : 0 < x ^ length p) by (apply pow_lt; assumption).
      assert (0 < peval (rev p) (/ x)) by nra; nra.
    + assert (Z1 : forall p, peval p 0 = IZR (hd 0%Z p)) by (intros [|c r]; simpl; ring).
      rewrite Rmult_0_r, Z1 in Qw; rewrite Z1.
      assert (K : forall r power, (0 < IZR power) -> 0 < IZR (hd 0%Z (rev (stretch b r power))) -> 0 < IZR (hd 0%Z (rev r))).
      { clear - B; induction r as [|c r IH]; intros power pp; simpl; [lra|].
        destruct r as [|d r]; [simpl; rewrite mult_IZR; intro; nra|].
        intro H; assert (G : forall (l : list Z) c, l <> [] -> hd 0%Z (l ++ [c]) = hd 0%Z l) by (intros [|e l] c' N; [contradiction|reflexivity]).
        rewrite G in H |- * by (intro N; apply (f_equal (@length Z)) in N; rewrite rev_length in N; discriminate).
        apply (IH (power * b)%Z); [rewrite mult_IZR; nra|exact H]. }
      rewrite <- (rev_involutive p); apply (K (rev p) 1%Z); lra.
Qed.

(* ---- The theorems relied on: a frequency inequality, and what follows for all nonlinearities of a class ---- *)

(* With the gains l and k of the ends of the class: D = den + l num, X = den + k num; H = num / den after the shift by l
   is G = num / D, and X / D = 1 + (k - l) G. *)
Definition over_frequencies (point : R -> C) (E : R -> C -> C -> R) (num den : list R) (l k : R) : Prop :=
  exists eps, 0 < eps /\ forall w, 0 <= w ->
    eps * square (closed num den l (point w)) <= E w (closed num den k (point w)) (closed num den l (point w)).
Definition axis (w : R) : C := (0, w).
(* Every z on the upper half of the unit circle but -1. *)
Definition circle (w : R) : C := ((1 - w * w) / (1 + w * w), 2 * w / (1 + w * w)).
(* Re (M X conj D) = |D|^2 Re (M (1 + (k - l) G)). *)
Definition with_multiplier (M : R -> C) (w : R) (X D : C) : R := re (cmul (M w) (cmul X (conj_ D))).

Definition proper (num den : list R) (l : R) : Prop :=
  (length num <= length den)%nat /\ hd 0 den <> 0 /\
  hd 0 den + l * (if (length num =? length den)%nat then hd 0 num else 0) <> 0.
Definition locally_lipschitz (phi : R -> R) : Prop :=
  forall r, exists L, forall s t, Rabs s <= r -> Rabs t <= r -> Rabs (phi s - phi t) <= L * Rabs (s - t).
Definition all_tend_to_0 (den : list R) (xi : nat -> R -> R) : Prop :=
  forall j, (S j < length den)%nat -> tends_to (xi j) 0.

Definition off_axis (alpha w : R) : C := (1, alpha).
Definition off_axis_circle_criterion : Prop := forall num den l k alpha phi xi,
  proper num den l -> l < k -> in_left_half_plane (closed num den l) ->
  over_frequencies axis (with_multiplier (off_axis alpha)) num den l k ->
  phi 0 = 0 -> slopes_in l k phi -> flow_of num den phi xi -> all_tend_to_0 den xi.

(* 1 + theta s / (1 - tau s^2) *)
Definition park (theta tau w : R) : C := (1, theta * w / (1 + tau * w * w)).
Definition park_criterion : Prop := forall num den l k theta tau phi xi,
  proper num den l -> (length num < length den)%nat \/ theta = 0 -> l < k -> 0 <= tau -> in_left_half_plane (closed num den l) ->
  over_frequencies axis (with_multiplier (park theta tau)) num den l k ->
  phi 0 = 0 -> slopes_in l k phi -> flow_of num den phi xi -> all_tend_to_0 den xi.

(* 1 + theta s - sum c (a / (a + s))^n, or (a / (a - s))^n: kernels of mass c, causal or not. *)
Definition lag (a w : R) : C := (a * a / (a * a + w * w), - (a * w / (a * a + w * w))).
Definition kernel : Type := (R * R * nat * bool)%type.
Definition weight (h : kernel) : R := match h with (c, _, _, _) => c end.
Fixpoint kernels (hs : list kernel) (w : R) : C :=
  match hs with
  | (c, a, n, causal) :: r =>
      cadd (cmul (real (- c)) (if causal then cpow (lag a w) n else conj_ (cpow (lag a w) n))) (kernels r w)
  | [] => (0, 0)
  end.
Definition rates (hs : list kernel) : Prop := Forall (fun h => match h with (_, a, _, _) => 0 < a end) hs.
Definition mass (cs : list R) : R := fold_right (fun c m => Rabs c + m) 0 cs.
Definition zames_falb (theta : R) (hs : list kernel) (w : R) : C := cadd (1, theta * w) (kernels hs w).
Definition zames_falb_for {K : Type} (M : R -> list K -> R -> C) (weight : K -> R) (rates : list K -> Prop) : Prop :=
  forall num den l k theta hs phi xi,
  proper num den l -> (length num < length den)%nat \/ theta = 0 -> l < k -> mass (map weight hs) <= 1 -> rates hs ->
  in_left_half_plane (closed num den l) -> over_frequencies axis (with_multiplier (M theta hs)) num den l k ->
  phi 0 = 0 -> slopes_in l k phi -> (Forall (fun h => 0 <= weight h) hs \/ odd phi) ->
  flow_of num den phi xi -> all_tend_to_0 den xi.
Definition zames_falb_theorem : Prop := zames_falb_for zames_falb weight rates.

(* 1 + theta s - sum c e^(- tau s): kernels that are delays, of either sign. *)
Fixpoint delays (hs : list (R * R)) (w : R) : C :=
  match hs with
  | (c, tau) :: r => cadd (cmul (real (- c)) (cos (tau * w), - sin (tau * w))) (delays r w)
  | [] => (0, 0)
  end.
Definition zames_falb_delays (theta : R) (hs : list (R * R)) (w : R) : C := cadd (1, theta * w) (delays hs w).
Definition zames_falb_theorem_for_delays : Prop := zames_falb_for zames_falb_delays fst (fun _ => True).

(* 1 - sum c z^-i, or z^i: taps. *)
Definition tap : Type := (R * nat * bool)%type.
Definition tap_weight (h : tap) : R := match h with (c, _, _) => c end.
Fixpoint taps (hs : list tap) (w : R) : C :=
  match hs with
  | (c, i, causal) :: r =>
      cadd (cmul (real (- c)) (if causal then conj_ (cpow (circle w) i) else cpow (circle w) i)) (taps r w)
  | [] => (0, 0)
  end.
Definition zames_falb_steps (hs : list tap) (w : R) : C := cadd (1, 0) (taps hs w).
Definition zames_falb_theorem_in_steps : Prop := forall num den l k hs phi xi,
  proper num den l -> l < k -> mass (map tap_weight hs) <= 1 -> Forall (fun h => match h with (_, i, _) => i <> O end) hs ->
  in_unit_disc (closed num den l) -> over_frequencies circle (with_multiplier (zames_falb_steps hs)) num den l k ->
  phi 0 = 0 -> slopes_in l k phi -> (Forall (fun h => 0 <= tap_weight h) hs \/ odd phi) ->
  steps_of num den phi xi -> Un_cv xi 0.

(* |D|^2 Re (1 + (k - l) G + q (1 - 1/z) (k - l) G), for odd nonlinearities 1 + 1/z, and Jury's and Lee's. *)
Definition tsypkin (q w : R) (X D : C) : R :=
  re (cmul X (conj_ D))
  + q * re (cmul (cadd (1, 0) (cmul (real (-1)) (conj_ (circle w)))) (cmul (cadd X (cmul (real (-1)) D)) (conj_ D))).
Definition tsypkin_odd (q w : R) (X D : C) : R :=
  re (cmul X (conj_ D)) + q * re (cmul (cadd (1, 0) (conj_ (circle w))) (cmul (cadd X (cmul (real (-1)) D)) (conj_ D))).
Definition jury_lee (q w : R) (X D : C) : R :=
  re (cmul X (conj_ D)) + q * re (cmul (cadd (circle w) (-1, 0)) (cmul (cadd X (cmul (real (-1)) D)) (conj_ D)))
  - q / 2 * square (cadd (circle w) (-1, 0)) * square (cadd X (cmul (real (-1)) D)).
Definition in_steps (E : R -> R -> C -> C -> R) (class : R -> R -> (R -> R) -> Prop) : Prop :=
  forall num den l k q phi xi,
  proper num den l -> (length num < length den)%nat -> l < k -> 0 <= q -> in_unit_disc (closed num den l) ->
  over_frequencies circle (E q) num den l k ->
  in_sector l k phi -> locally_lipschitz phi -> class l k phi -> steps_of num den phi xi -> Un_cv xi 0.
Definition rises (l k : R) (phi : R -> R) : Prop := forall s t, s < t -> l * (t - s) <= phi t - phi s.
Definition rises_and_odd (l k : R) (phi : R -> R) : Prop := rises l k phi /\ odd phi.
Definition rises_less (l k : R) (phi : R -> R) : Prop := forall s t, s < t -> phi t - phi s <= k * (t - s).
Definition tsypkin_criterion : Prop := in_steps tsypkin rises.
Definition tsypkin_criterion_for_odd : Prop := in_steps tsypkin_odd rises_and_odd.
Definition jury_lee_criterion : Prop := in_steps jury_lee rises_less.
