Require Import Reals ZArith List Lra Lia Bool.
Import ListNotations.
Open Scope R_scope.

(* ---- Linear and quadratic forms with integer coefficients ---- *)

Fixpoint dot (u : list Z) (z : list R) : R :=
  match u, z with a :: u', x :: z' => IZR a * x + dot u' z' | _, _ => 0 end.

Fixpoint norm2 (z : list R) : R := match z with x :: z' => x * x + norm2 z' | [] => 0 end.
Lemma norm2_nonneg : forall z, 0 <= norm2 z.
Proof. induction z as [|x z IH]; cbn [norm2]; [lra|]; pose proof (Rle_0_sqr x); unfold Rsqr in *; lra. Qed.

(* An upper triangle by rows: the entry on the diagonal, and those beside it, each of which counts twice. *)
Definition triangle := list (Z * list Z).
Fixpoint qf (M : triangle) (z : list R) : R :=
  match M, z with (a, v) :: M', x :: z' => IZR a * (x * x) + 2 * x * dot v z' + qf M' z' | _, _ => 0 end.

Fixpoint add (u v : list Z) : list Z :=
  match u, v with a :: u', b :: v' => (a + b)%Z :: add u' v' | [], _ => v | _, [] => u end.
Definition scale (c : Z) (u : list Z) : list Z := map (Z.mul c) u.
Fixpoint madd (M N : triangle) : triangle :=
  match M, N with
  | (a, u) :: M', (b, v) :: N' => ((a + b)%Z, add u v) :: madd M' N'
  | [], _ => N
  | _, [] => M
  end.
Definition mscale (c : Z) (M : triangle) : triangle := map (fun r => (c * fst r, scale c (snd r))%Z) M.
Fixpoint product (c : Z) (u v : list Z) : triangle :=
  match u, v with
  | a :: u', b :: v' => (2 * c * a * b, add (scale (c * a) v') (scale (c * b) u'))%Z :: product c u' v'
  | _, _ => []
  end.

Lemma dot_nil : forall u, dot u [] = 0.
Proof. now destruct u. Qed.
Lemma dot_add : forall u v z, dot (add u v) z = dot u z + dot v z.
Proof.
  induction u as [|a u IH]; intros [|b v] [|x z]; simpl; try lra.
  rewrite IH, plus_IZR; lra.
Qed.
Lemma dot_scale : forall c u z, dot (scale c u) z = IZR c * dot u z.
Proof.
  induction u as [|a u IH]; intros [|x z]; simpl; try lra.
  unfold scale in IH; rewrite IH, mult_IZR; lra.
Qed.
Lemma qf_add : forall M N z, qf (madd M N) z = qf M z + qf N z.
Proof.
  induction M as [|[a u] M IH]; intros [|[b v] N] [|x z]; simpl; try lra.
  rewrite IH, dot_add, plus_IZR; lra.
Qed.
Lemma qf_scale : forall c M z, qf (mscale c M) z = IZR c * qf M z.
Proof.
  induction M as [|[a u] M IH]; intros [|x z]; simpl; try lra.
  unfold mscale in IH; rewrite IH, dot_scale, mult_IZR; lra.
Qed.
Lemma qf_product : forall c u v z, qf (product c u v) z = 2 * IZR c * dot u z * dot v z.
Proof.
  intros c; induction u as [|a u IH]; intros [|b v] [|x z]; cbn [product qf dot]; try lra.
  rewrite IH, dot_add, !dot_scale, !mult_IZR; ring.
Qed.

(* ---- A test that a form is nowhere negative: Lagrange's reduction, each step divided by the pivot before ---- *)

Fixpoint zero (v : list Z) : bool := match v with a :: v' => (a =? 0)%Z && zero v' | [] => true end.
Fixpoint same (u v : list Z) : bool :=
  match u, v with a :: u', b :: v' => (a =? b)%Z && same u' v' | [], [] => true | _, _ => false end.
Fixpoint msame (M N : triangle) : bool :=
  match M, N with
  | (a, u) :: M', (b, v) :: N' => (a =? b)%Z && same u v && msame M' N'
  | [], [] => true
  | _, _ => false
  end.
Definition mdiv (c : Z) (M : triangle) : triangle :=
  map (fun r => (fst r / c, map (fun a => a / c) (snd r))%Z) M.
Fixpoint psd (n : nat) (before : Z) (M : triangle) : bool :=
  match n, M with
  | O, _ => true
  | S n', (a, v) :: M' =>
      if (0 <? a)%Z then
        let rest := madd (mscale (2 * a) M') (product (-1) v v) in
        let less := mdiv (2 * before) rest in
        msame (mscale (2 * before) less) rest && psd n' a less
      else (a =? 0)%Z && zero v && psd n' before M'
  | _, [] => false
  end.

Lemma dot_zero : forall v z, zero v = true -> dot v z = 0.
Proof.
  induction v as [|a v IH]; intros [|x z]; simpl; try easy.
  rewrite andb_true_iff, Z.eqb_eq; intros [-> H]; rewrite IH; auto; lra.
Qed.
Lemma same_eq : forall u v, same u v = true -> u = v.
Proof.
  induction u as [|a u IH]; intros [|b v]; simpl; try easy.
  rewrite andb_true_iff, Z.eqb_eq; intros [-> H]; f_equal; auto.
Qed.
Lemma msame_eq : forall M N, msame M N = true -> M = N.
Proof.
  induction M as [|[a u] M IH]; intros [|[b v] N]; simpl; try easy.
  rewrite !andb_true_iff, Z.eqb_eq; intros [[-> H] K]; f_equal; auto; f_equal; now apply same_eq.
Qed.
Lemma psd_sound : forall n before M z,
  (0 < before)%Z -> psd n before M = true -> length z = n -> 0 <= qf M z.
Proof.
  induction n as [|n IH]; intros before M [|x z] pos H len; try discriminate.
  - destruct M as [|[a v] M]; simpl; lra.
  - destruct M as [|[a v] M]; [discriminate|]; cbn [psd] in H; cbn [qf]; injection len as len.
    destruct (Z.ltb_spec 0 a) as [apos|_].
    + apply andb_true_iff in H as [E H].
      apply msame_eq in E.
      pose proof (IH a _ z apos H len) as D.
      apply (f_equal (fun M => qf M z)) in E.
      rewrite qf_scale, qf_add, qf_scale, qf_product in E.
      apply IZR_lt in apos, pos.
      rewrite !mult_IZR in E.
      assert (F : 0 <= 2 * IZR a * qf M z - 2 * dot v z * dot v z) by nra.
      assert (G : 0 <= IZR a * (IZR a * (x * x) + 2 * x * dot v z + qf M z)).
      { replace (IZR a * (IZR a * (x * x) + 2 * x * dot v z + qf M z))
          with ((IZR a * x + dot v z) ^ 2 + (2 * IZR a * qf M z - 2 * dot v z * dot v z) / 2) by field.
        pose proof (pow2_ge_0 (IZR a * x + dot v z)); lra. }
      apply (Rmult_le_reg_l (IZR a)); lra.
    + rewrite !andb_true_iff, Z.eqb_eq in H; destruct H as [[-> K] H].
      rewrite (dot_zero v z K); pose proof (IH before M z pos H len); lra.
Qed.

(* ---- Sums of products of two linear forms ---- *)

Definition term := (Z * (list Z * list Z))%type.
Fixpoint value (ts : list term) (z : list R) : R :=
  match ts with (c, (u, v)) :: ts' => IZR c * (dot u z * dot v z) + value ts' z | [] => 0 end.
Fixpoint matrix (ts : list term) : triangle :=
  match ts with (c, (u, v)) :: ts' => madd (product c u v) (matrix ts') | [] => [] end.
Definition times (k : Z) (ts : list term) : list term := map (fun t => ((k * fst t)%Z, snd t)) ts.
Definition squares (fs : list (list Z)) : list term := map (fun f => (1%Z, (f, f))) fs.

(* The test: [value ts z >= 0] for every [z] of length [n]. *)
Definition nonneg (n : nat) (ts : list term) : bool := psd n 1 (matrix ts).

Lemma value_matrix : forall ts z, qf (matrix ts) z = 2 * value ts z.
Proof.
  induction ts as [|[c [u v]] ts IH]; intros z; simpl; [lra|].
  rewrite qf_add, qf_product, IH; ring.
Qed.
Lemma value_app : forall s t z, value (s ++ t) z = value s z + value t z.
Proof. induction s as [|[c [u v]] s IH]; intros; simpl; [lra|rewrite IH; lra]. Qed.
Lemma value_times : forall k ts z, value (times k ts) z = IZR k * value ts z.
Proof.
  induction ts as [|[c [u v]] ts IH]; intros z; simpl; [lra|].
  unfold times in IH; rewrite IH, mult_IZR; ring.
Qed.
Lemma nonneg_sound : forall n ts z, nonneg n ts = true -> length z = n -> 0 <= value ts z.
Proof.
  intros n ts z H len; pose proof (psd_sound n 1 (matrix ts) z ltac:(lia) H len).
  rewrite value_matrix in H0; lra.
Qed.

(* ---- [V = x^T P x], where [x] are the values of linear forms ---- *)

Fixpoint sumprod (u v : list R) : R :=
  match u, v with a :: u', b :: v' => a * b + sumprod u' v' | _, _ => 0 end.
Definition V (P : list (list Z)) (x : list R) : R := sumprod x (map (fun row => dot row x) P).
Fixpoint combine_forms (row : list Z) (fs : list (list Z)) : list Z :=
  match row, fs with a :: row', f :: fs' => add (scale a f) (combine_forms row' fs') | _, _ => [] end.
(* The terms of [sum_ij P_ij (f_i z) (g_j z)]. *)
Fixpoint bilinear (P : list (list Z)) (fs gs : list (list Z)) : list term :=
  match P, fs with row :: P', f :: fs' => (1%Z, (f, combine_forms row gs)) :: bilinear P' fs' gs | _, _ => [] end.
Definition at_ (fs : list (list Z)) (z : list R) : list R := map (fun f => dot f z) fs.

Lemma dot_combine : forall row fs z, dot (combine_forms row fs) z = dot row (at_ fs z).
Proof.
  induction row as [|a row IH]; intros [|f fs] z; simpl; try easy.
  now rewrite dot_add, dot_scale, IH.
Qed.
Lemma value_bilinear : forall P fs gs z,
  value (bilinear P fs gs) z = sumprod (at_ fs z) (map (fun row => dot row (at_ gs z)) P).
Proof.
  induction P as [|row P IH]; intros [|f fs] gs z; simpl; try easy.
  rewrite IH, dot_combine; ring.
Qed.

Lemma V_scaled : forall P c z, V P (map (Rmult c) z) = c * c * V P z.
Proof.
  intros P c z; unfold V.
  assert (D : forall row us, dot row (map (Rmult c) us) = c * dot row us).
  { induction row as [|a row IH]; intros [|x us]; cbn [dot map]; try ring; rewrite IH; ring. }
  rewrite (map_ext (fun row => dot row (map (Rmult c) z)) (fun row => c * dot row z)) by (intro; apply D).
  generalize P; generalize z at 1 3 as us; induction us as [|x us IH]; intros [|row P']; cbn [map sumprod]; try ring.
  rewrite IH; ring.
Qed.
Lemma norm2_scaled : forall c z, norm2 (map (Rmult c) z) = c * c * norm2 z.
Proof. intros c z; induction z as [|x z IH]; cbn [map norm2]; [ring|]; rewrite IH; ring. Qed.
Lemma dot_place : forall i c z, dot (repeat 0%Z i ++ [c]) z = IZR c * nth i z 0.
Proof. induction i as [|i IH]; intros c [|x z]; cbn [repeat app dot nth]; try ring; rewrite IH; ring. Qed.

(* Combinations of two vectors. *)
Fixpoint lcomb (a b : R) (u v : list R) : list R :=
  match u, v with x :: u', y :: v' => (a * x + b * y) :: lcomb a b u' v' | _, _ => [] end.
Lemma dot_lcomb : forall a b r u v, length u = length v -> dot r (lcomb a b u v) = a * dot r u + b * dot r v.
Proof.
  intros a b; induction r as [|c r IH]; intros [|x u] [|y v] E; simpl in *; try discriminate; try lra.
  rewrite IH by lia; ring.
Qed.
Lemma sumprod_left : forall a b u v w, length u = length v ->
  sumprod (lcomb a b u v) w = a * sumprod u w + b * sumprod v w.
Proof.
  intros a b; induction u as [|x u IH]; intros [|y v] [|c w] E; simpl in *; try discriminate; try lra.
  rewrite IH by lia; ring.
Qed.
Lemma sumprod_right : forall a b (P : list (list Z)) w u v, length u = length v ->
  sumprod w (map (fun r => dot r (lcomb a b u v)) P)
  = a * sumprod w (map (fun r => dot r u) P) + b * sumprod w (map (fun r => dot r v) P).
Proof.
  intros a b; induction P as [|r P IH]; intros [|c w] u v E; simpl; try lra.
  rewrite (IH w u v E), (dot_lcomb a b r u v E); ring.
Qed.
Lemma lcomb_length : forall a b u v, length u = length v -> length (lcomb a b u v) = length u.
Proof. intros a b; induction u as [|x u IH]; intros [|y v] E; simpl in *; try discriminate; [reflexivity|]; rewrite IH; lia. Qed.

(* ---- What a class says of one pair (sigma, phi(sigma)) ---- *)

Definition in_sector (l u : R) (phi : R -> R) : Prop :=
  phi 0 = 0 /\ forall y, l * (y * y) <= y * phi y <= u * (y * y).
Definition above (l : R) (phi : R -> R) : Prop := phi 0 = 0 /\ forall y, l * (y * y) <= y * phi y.
Definition slopes_in (a b : R) (f : R -> R) : Prop := forall s t, s < t -> a * (t - s) <= f t - f s <= b * (t - s).
Definition odd (f : R -> R) : Prop := forall y, f (- y) = - f y.

Lemma sector : forall l u phi y p, in_sector l u phi -> phi y = p -> 0 <= (p - l * y) * (u * y - p).
Proof.
  intros l u phi y p [H0 H] <-; destruct (H y) as [A B]; set (p := phi y) in *; destruct (Req_dec y 0) as [E|E].
  - unfold p; rewrite E, H0; lra.
  - assert (0 < y * y) by nra.
    apply (Rmult_le_reg_l (y * y)); [assumption|].
    replace (y * y * ((p - l * y) * (u * y - p))) with ((y * p - l * (y * y)) * (u * (y * y) - y * p)) by ring.
    nra.
Qed.
Lemma part : forall a b x y u v, u = a * x -> v = b * y -> 0 <= a -> 0 <= b -> 0 <= x * y -> 0 <= u * v.
Proof.
  intros a b x y u v -> ->; intros; replace (a * x * (b * y)) with (a * b * (x * y)) by ring; apply Rmult_le_pos; nra.
Qed.
Lemma half_line : forall l phi y p, above l phi -> phi y = p -> 0 <= (p - l * y) * y.
Proof. intros l phi y p [_ H] <-; pose proof (H y); nra. Qed.

Lemma between_ends : forall l u d, l <= d <= u -> exists t, 0 <= t <= 1 /\ d = t * u + (1 - t) * l.
Proof.
  intros l u d D; destruct (Req_dec u l) as [e|ne].
  - exists 0; split; [lra|]; rewrite e in *; lra.
  - exists ((d - l) / (u - l)); split; [|field; lra].
    assert (P : 0 < u - l) by lra; split; apply (Rmult_le_reg_r (u - l)); try exact P;
      unfold Rdiv; rewrite ?Rmult_assoc, ?Rinv_l; lra.
Qed.
Lemma gain_of : forall l u phi y p, in_sector l u phi -> l <= u -> phi y = p -> exists d, l <= d <= u /\ p = d * y.
Proof.
  intros l u phi y p [Z H] lu <-; destruct (Req_dec y 0) as [->|N].
  - exists l; rewrite Z; split; [lra|ring].
  - exists (phi y / y); split; [|field; exact N].
    assert (P : 0 < y * y) by nra; pose proof (H y).
    split; apply (Rmult_le_reg_r (y * y)); try exact P;
      replace (phi y / y * (y * y)) with (y * phi y) by (field; exact N); lra.
Qed.

(* ---- Discrete time: V >= 0 falls by at least a multiple of |z|^2 where the products of the class are >= 0 ---- *)

(* Weights, and pairs of linear forms whose products are nonnegative for the class. *)
Fixpoint products_hold (S : list term) (z : list R) : Prop :=
  match S with (_, (u, v)) :: S' => 0 <= dot u z * dot v z /\ products_hold S' z | [] => True end.
Fixpoint weights (S : list term) : bool := match S with (c, _) :: S' => (0 <=? c)%Z && weights S' | [] => true end.

Lemma class_nonneg : forall S z, weights S = true -> products_hold S z -> 0 <= value S z.
Proof.
  induction S as [|[c [u v]] S IH]; intros z; simpl; [lra|].
  rewrite andb_true_iff, Z.leb_le; intros [C W] [H K].
  apply IZR_le in C; pose proof (IH z W K); nra.
Qed.

Lemma squares_nonneg : forall fs z, 0 <= value (squares fs) z.
Proof. induction fs as [|f fs IH]; intros z; simpl; [lra|]. specialize (IH z); nra. Qed.
Lemma squares_at : forall fs z, value (squares fs) z = norm2 (at_ fs z).
Proof.
  induction fs as [|f fs IH]; intro z; [reflexivity|]; cbn [squares map value norm2 at_].
  unfold squares, at_ in IH; rewrite IH; ring.
Qed.
Lemma squares_in : forall fs f z, In f fs -> dot f z * dot f z <= value (squares fs) z.
Proof.
  induction fs as [|g fs IH]; intros f z; [easy|]; intros [->|H]; cbn [squares map value].
  - pose proof (squares_nonneg fs z); unfold squares in *; lra.
  - pose proof (IH f z H); unfold squares in *; nra.
Qed.

Definition falls_by_steps (n : nat) (P now next : list (list Z)) (S : list term) (N : Z) (small : list (list Z)) :=
  (0 <? N)%Z && nonneg n (bilinear P now now) &&
  nonneg n (times N (bilinear P now now ++ times (-1) (bilinear P next next) ++ times (-1) S)
            ++ times (-1) (squares small)).

(* The same with J >= 0 beside V, which [turn] changes. *)
Theorem by_steps_beside : forall n P now next turn S N small (z : nat -> list R) (J : nat -> R),
  falls_by_steps n P now next (turn ++ S) N small = true ->
  (forall t, length (z t) = n) ->
  (forall t, at_ now (z (Datatypes.S t)) = at_ next (z t)) ->
  (forall t, 0 <= J t) -> (forall t, J (Datatypes.S t) = J t + value turn (z t)) ->
  (forall t, 0 <= value S (z t)) ->
  forall f, In f small -> Un_cv (fun t => dot f (z t)) 0.
Proof.
  intros n P now next turn S N small z J check len step Jpos Jstep class f Hf.
  unfold falls_by_steps in check; rewrite !andb_true_iff, Z.ltb_lt in check.
  destruct check as [[pos low] falls].
  apply IZR_lt in pos.
  set (v := fun t => V P (at_ now (z t)) + J t).
  assert (vpos : forall t, 0 <= v t).
  { intro t; unfold v, V; rewrite <- value_bilinear; pose proof (Jpos t).
    pose proof (nonneg_sound n _ (z t) low (len t)); lra. }
  assert (drop : forall t, dot f (z t) * dot f (z t) <= IZR N * (v t - v (Datatypes.S t))).
  { intro t; pose proof (nonneg_sound n _ (z t) falls (len t)) as F.
    rewrite !value_app, !value_times, !value_app, !value_times, !value_app, !value_bilinear in F.
    unfold v, V; rewrite step, Jstep.
    pose proof (class t); pose proof (squares_in small f (z t) Hf); nra. }
  assert (down : Un_decreasing v).
  { intro t; pose proof (drop t); apply (Rmult_le_reg_l (IZR N)); nra. }
  destruct (decreasing_cv v down) as [l lim].
  { exists 0; intros x [t ->]; unfold opp_seq; pose proof (vpos t); lra. }
  intros eps epos.
  destruct (lim (eps * eps / (2 * IZR N))) as [T HT].
  { apply Rlt_gt, Rdiv_lt_0_compat; nra. }
  exists T; intros t Ht; unfold R_dist; rewrite Rminus_0_r.
  pose proof (HT t Ht) as A; pose proof (HT (Datatypes.S t) ltac:(lia)) as B.
  unfold R_dist in A, B; apply Rabs_def2 in A as [A1 A2], B as [B1 B2].
  assert (C : v t - v (Datatypes.S t) < 2 * (eps * eps / (2 * IZR N))) by lra.
  replace (2 * (eps * eps / (2 * IZR N))) with (eps * eps / IZR N) in C by (field; lra).
  apply (Rmult_lt_compat_l (IZR N)) in C; [|assumption].
  replace (IZR N * (eps * eps / IZR N)) with (eps * eps) in C by (field; lra).
  pose proof (drop t).
  rewrite <- (Rabs_right eps) by lra; apply Rsqr_lt_abs_0; unfold Rsqr; lra.
Qed.
Theorem by_steps : forall n P now next S N small (z : nat -> list R),
  falls_by_steps n P now next S N small = true ->
  (forall t, length (z t) = n) ->
  (forall t, at_ now (z (Datatypes.S t)) = at_ next (z t)) ->
  (forall t, 0 <= value S (z t)) ->
  forall f, In f small -> Un_cv (fun t => dot f (z t)) 0.
Proof.
  intros n P now next S N small z check len step.
  apply (by_steps_beside n P now next [] S N small z (fun _ => 0) check len step); intro; simpl; lra.
Qed.

Lemma Un_cv_part : forall q f g, 1 <= q -> (forall t : nat, g t = q * f t) -> Un_cv g 0 -> Un_cv f 0.
Proof.
  intros q f g Hq E G eps epos; destruct (G eps epos) as [T HT]; exists T; intros t Ht.
  pose proof (HT t Ht) as A; unfold R_dist in *; rewrite E, Rminus_0_r, Rabs_mult, (Rabs_right q) in A by lra.
  rewrite Rminus_0_r; pose proof (Rabs_pos (f t)); nra.
Qed.
